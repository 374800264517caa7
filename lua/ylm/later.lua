--- Functions of modules above the one that calls them: ylm/init.lua sets them, each loads its module when it is first called.
--
--     later.live(scene, options)      -- ylm.live

return {}

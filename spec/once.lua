--- Specs whose subject is not the interpreter: kernels, devices, pictures, the tree. Every other spec runs under each Lua.

return {
  -- One Lua runs these: the first, LuaJIT in `make test`, whose loops take a third of the time.
  one = [[
    ambient bounce_render bricks c check choose cli_sh codec codegen denoise derivatives dering display emit emit_gloss emit_merge
    engine_fit engines equal_files exposure far_from_origin far_scene first_call flip gather gloss_bounced gloss_field glossy
    grid_bake grid_prints grid_sample grid_sides grid_surface grid_unmet grid_update grid_update_flat grid_update_memory
    grid_update_octree grid_update_random grid_update_undo grid_update_view grounds guide guides hostile_meshes install inverse
    kernels knob ladder light light_blocks light_disk light_environment light_lobe light_merged light_photometric
    light_polygon light_polygon_kernel light_polygon_scene light_sampled light_sky light_sun light_textured light_tree lightmap
    lightmap_browser lightmaps live live_display material material_kinds material_table narrow neon no_lights occlusion oidn
    papers path photometry photometry_file plot plot_lines prepared_look probes radiosity readme refresh relight render
    render_noise rounds run sealed_rooms
    sh_eval sh_exponential sh_product sh_project sh_rotate shade shadow_bodies shadow_fields shadow_rays shell site
    small_bricks small_grid sphere_set spot surface surface_grid surface_promise targets team_bake team_bricks team_faults texture
    transfer transfer_vectors two_rooms_light unwrap view view_bar view_display view_grid virtual_gather virtual_gaussian
    virtual_gloss virtual_kernel virtual_levels virtual_lights virtual_near virtual_random virtual_subset
    virtual_tree virtual_truth virtual_visible virtual_walls vulkan vulkan_array vulkan_bake vulkan_fault
    vulkan_image vulkan_keep vulkan_light vulkan_octree vulkan_points vulkan_render vulkan_rims vulkan_sample
    vulkan_sh vulkan_surface vulkan_tolerance vulkan_uniform]],

  -- The last Lua runs these, Lua 5.4 in `make test`: their subject needs it, or counts requests of memory, which its own are.
  last = [[
    abi documentation material_file memory memory_picture options page states style]],

  -- The first Lua and the last these, without integers and with.
  two = [[
    array_math cli cli_messages cli_render cli_status environment geometry gltf grid_file progress refusals
    scene_like team trace]],

  -- The longest: they begin where no run has measured specs (build/spec has the seconds), and `make quick` leaves them out.
  long = [[
    grid_update_flat narrow neon papers vulkan_keep vulkan_light vulkan_octree vulkan_points vulkan_rims vulkan_tolerance]],

  -- The next longest, of five seconds and more: they begin after those, where no run has measured specs.
  early = [[
    bounce_render bricks cli codegen denoise documentation gather grid_sides grid_update grounds guide guides hostile_meshes
    install inverse light_tree lightmaps live live_display material_file memory memory_picture options page probes radiosity
    readme refusals rounds run small_grid style surface_grid surface_promise targets team_bricks two_rooms_light view_grid
    virtual_near vulkan_fault vulkan_sample]],

  -- Specs that run no code of the build: sanitizers find nothing there.
  text = [[
    check codegen ladder neon style]],

  -- Specs of arguments and of examples in texts: other specs run the same code by threads, and ThreadSanitizer leaves these out.
  words = [[
    cli documentation guide material_file options page readme refusals run]],
}

--- Specs whose subject is not the interpreter: kernels, devices, pictures, the tree. One Lua runs them, or the first
-- and the last, with integers and without, where seconds stand in braces; every other spec runs under each. Behind a name stand
-- its seconds of processor time: spec/run begins with the longest.

return {
  memory = { 7 }, documentation = { 5 }, cli_render = { 2 }, cli_status = { 2 }, cli_messages = { 2 }, grid_file = { 2 },
  array_math = { 1 }, cli_sh = 3, team = { 8 }, team_bake = 6, team_bricks = 8, team_faults = 2,
  options = { 7 }, readme = { 6 }, gather = 6,
  vulkan_rims = 36, vulkan_light = 40, grid_update_flat = 16, neon = 46, vulkan_octree = 31, vulkan_tolerance = 16,
  vulkan_points = 27, vulkan_sample = 14, papers = 32, codegen = 10, vulkan_keep = 20, vulkan_fault = 12,
  grid_update = 6, vulkan_image = 10, grid_update_octree = 10, memory_picture = 11, view_grid = 8,
  vulkan_uniform = 7, light_tree = 7,
  grid_update_random = 5, view_bar = 5, install = 5, vulkan_sh = 5, grid_bake = 5, vulkan_surface = 4,
  light_blocks = 4, material_kinds = 6, material_file = 5, material_table = 4,
  shadow_bodies = 3, material = 4, grid_surface = 4, light = 4, style = 4,
  choose = 4, sh_project = 4, vulkan_bake = 4, view = 4, occlusion = 3,
  grid_sample = 3, grid_update_undo = 3, texture = 3, plot = 3, sh_eval = 2, vulkan_render = 2, no_lights = 2,
  light_polygon_kernel = 2, shade = 2, render_noise = 2, render = 2, grid_update_memory = 1, grid_update_view = 1,
  codec = 1, light_textured = 1, sh_product = 1, light_polygon_scene = 1, light_merged = 1, sh_rotate = 1, ladder = 1,
  irradiance_measure = 3, refresh = 2, abi = 1, bounce_render = 4, path = 5, light_sky = 3, first_call = 5, flip = 3,
  two_rooms_light = 4, relight = 3,
  transfer = 1, radiosity = 1, lightmap = 1, virtual_tree = 3,
  transfer_vectors = 3, light_sampled = 1, virtual_lights = 1, virtual_kernel = 2, glossy = 3, gloss_bounced = 5,
  gloss_field = 2, virtual_near = 2, virtual_levels = 1,
  ambient = 1, c = 3,
  emit = 1, emit_merge = 1, emit_gloss = 2, virtual_gather = 2, spot = 1, guide = 11, plot_lines = 1, virtual_gloss = 2,
  virtual_gaussian = 1, virtual_random = 1, display = 3, virtual_subset = 1, virtual_visible = 1, virtual_truth = 2,
  engines = 3, site = 2,
  scene_like = { 1 }, gltf = { 1 }, sh_exponential = 1, shadow_fields = 6, shadow_rays = 2, sphere_set = 2, page = 8,
  bricks = 8, knob = 4, run = 1, shell = 1, surface = 2, dering = 3, virtual_walls = 1, far_from_origin = 3,
  prepared_look = 1, live = 11, live_display = 6,
}

/*
** calibration.h - the tuned constants of shading. Private to csrc/shade.
**
** Sizes of work move time alone: `make bench BENCH=transfer` prints rays and transfer vectors a second,
** BENCH=rays noise and time of pictures by rays to the lamps, BENCH=frames those of a moving picture.
*/
#ifndef YLM_SHADE_CALIBRATION_H
#define YLM_SHADE_CALIBRATION_H

/* -- camera rays: primary.c, incremental.c ------------------------------------------------------- */

/* Camera rays that are traced in one go. */
#define SHADE_RAYS 256
/* Cosine of the angle (10 degrees) within which normals may differ in one shading point. Moved by:
   errors at edges, and the number of points. */
#define SHADE_SAME_NORMAL 0.98480775f
/* The part of a lobe's width within which normals may differ, where surfaces gloss. */
#define SHADE_FINE 0.05
/* Samples of a pixel by which a point has other places, 1 .. 32. */
#define SHADE_PLACES 32
/* Pixels of a square, whose points are sampled together: each voxel that is seen in it is read
   once. */
#define SHADE_TILE 64

/* -- rays to lamps: raycast.c, transfer.c, occlusion.c ------------------------------------------- */

/* Rays of a point that start from one place, and places of a point, at most. Moved by: edges of shadows, and time. */
#define SHADE_PLACE_RAYS 2
#define SHADE_PLACES_MOST 16
/* The excess (ylm_material_excess) of a lobe below which rays are aimed at lamps alone. A wider one takes rays that its material
   chooses besides, 16 of each at least. Moved by: noise at equal rays of floors and metals under lamps and windows. */
#define SHADE_SOFT 4.0f
/* Rays whose f is found in one go. */
#define SHADE_LOBE_RAYS 16
/* Points that a thread takes at a time, and points whose rays are traced in one go, at most. */
#define SHADE_CAST_GRAIN 256
#define SHADE_CAST_POINTS 512
/* Occlusion rays that are traced in one go, unless one point has more. */
#define SHADE_OCCLUSION_RAYS 1024
/* Places of the measurement of occlusion that a thread takes at a time. */
#define SHADE_MEASURED_GRAIN 16
/* Points whose transfer vectors, and points whose lobes, a thread makes at a time. */
#define SHADE_TRANSFER_GRAIN 128
#define SHADE_LOBE_GRAIN 64
/* Rows of the picture of lamps that a thread takes at a time. */
#define SHADE_LAMP_ROWS 32

/* -- points that are shaded in one go ------------------------------------------------------------ */

/* Points whose light is asked for at once, and points that are sampled at once: their coefficients
   stay in the second-level cache. */
#define SHADE_LIGHT_POINTS 512
#define SHADE_GRID_POINTS 512
/* Points that are gathered at once: their sums stay in the first-level cache. */
#define SHADE_LINK_POINTS 256
/* Points whose light is known at once. */
#define SHADE_VECTOR_POINTS 256
/* Points or pixels that a thread takes at a time where one is a few numbers; pixels of a layer, and points near lights;
   points whose products are kept. */
#define SHADE_GRAIN 4096
#define SHADE_LAYER_GRAIN 1024
#define SHADE_KEPT_GRAIN 512
/* Points at which the noise of direct light is measured: a NOISE_PART-th of all within these bounds. */
#define NOISE_RAYS_LEAST 256
#define NOISE_RAYS_MOST 4096
/* Points whose surfaces are asked for at once. */
#define SHADE_FLATS 64

/* -- noise: noise.c, links.c --------------------------------------------------------------------- */

/* Points at which noise is measured: a NOISE_PART-th of all within these bounds. */
#define NOISE_LEAST 128
#define NOISE_MOST 512
#define NOISE_PART 32
/* The part of the mean radiance below which darkness excuses noise. */
#define NOISE_DARK 0.1
/* Points at which the noise of links is measured. */
#define NOISE_OF_LINKS 4096
/* Pixels on each side of one whose mean and variance count as its own: rounds.c. */
#define NOISE_REACH 4
/* Pixels on each side of a tile whose points have one weight of a pilot, and the part of the fewest rays behind it from which on a
   tile that asks for them has some: rounds.c. Moved by: time of pictures (loft, house). */
#define PLAN_TILE 32
#define PLAN_WORTH 0.5
/* Pixels on each side of one whose light tells its contrast; times the usual contrast, which counts as EDGE_LEAST at least, from
   which on a point has rays of its own: edges.c. Moved by: edges of the sun on a floor, and the time of pictures. */
#define EDGE_REACH 2
#define EDGE_CONTRAST 1.5
#define EDGE_LEAST 0.05
/* Points whose sets of links are found at once: sets.c. */
#define SETS_POINTS ((size_t)1 << 14)
/* Points by which it is learnt what sends light to them, at most. */
#define TARGETS_MOST 65536
/* Random numbers of the places that sets start from. */
#define SETS_PLACES 0x706c61636573u
/* Samples of each item by which noise is measured. */
#define CAST_TRIAL_SAMPLES 64
/* Random numbers of trials. */
#define CAST_TRIAL_CALLS 0x747269616cu
/* The part of the picture's mean square below which darkness excuses a mesh's noise. */
#define CAST_DARK 0.01
/* A pixel may have CAST_PIXEL_NOISE times a mesh's noise, relative to its own radiance and a part of the mesh's root mean
   square. More than CAST_PIXEL_MOST samples are not spent on it. */
#define CAST_PIXEL_NOISE 4
#define CAST_PIXEL_DARK 0.1
#define CAST_PIXEL_MOST 1024
/* Items of n samples look for n / CAST_FRESH_PART places of their own in the pixel, within these bounds. */
#define CAST_FRESH_PART 2
#define CAST_FRESH_LEAST 64
#define CAST_FRESH_MOST 512
/* Places that are found at once, and items whose places a thread finds at a time. */
#define CAST_FRESH_ROOM 65536
#define CAST_FRESH_GRAIN 64

/* -- light without most of its noise: denoise.c --------------------------------------------------- */

/* Cells of the disk around a point whose light may count, on a side; pixels of that of its second guide, of that by which its
   variance is known, and of its first guide. */
#define DENOISE_REACH 9
#define DENOISE_GUIDED 5.0f
#define DENOISE_VARIED 8.0f
#define DENOISE_FIRST 1.9f
/* Reach from which on a cell is 2 x 2 pixels. */
#define DENOISE_COARSE 4
/* Taps of even weight that are enough: of fewer, all within DENOISE_GUIDED pixels count. */
#define DENOISE_FEW 6
/* Light of a half is rare that is so many times what the other half has and what pixels around have, so many on each side; of
   light that bounces, without the other half, where all these show one surface. Moved by: spots that are left in a room under an
   overcast sky, noise beside the lamp's shade, and bias of blocks. */
#define DENOISE_RARE 24
#define DENOISE_RARE_BOUNCED 6
#define DENOISE_CALM 3
/* Squared cells that are added to the variance of places: slopes that few taps tell are drawn to 0. */
#define DENOISE_RIDGE 0.5
/* Points count whose normals are within 37 degrees and which are this near to each other's planes, in pixel widths. */
#define DENOISE_COSINE 0.8f
#define DENOISE_PLANE 2
/* Pixel widths in space within which points count, over those in the picture: light changes with places, not with how surfaces
   are turned to the camera. */
#define DENOISE_AROUND 1.5
/* The squared difference of guides that counts for nothing, over the sum of their variances. Moved by: widths of shadows'
   edges, and noise that is left (`make bench BENCH=interiors`). */
#define DENOISE_RANGE 9.0f
/* Variance below which guides count as known. */
#define DENOISE_LEAST 1e-24
/* Albedo of a channel below which its light is not told apart from none. */
#define DENOISE_ALBEDO 1e-4f
/* Lobes whose excess (ylm_material_excess), seen from this cosine, is above this are mirrors, whose light is left as it is; materials
   that gloss are told apart by so many numbers. Moved by: edges in reflections, and noise of floors. */
#define DENOISE_EYE 0.7f
#define DENOISE_NARROW 1.0f
#define DENOISE_MATERIALS 65536
/* Numbers that kernels may read behind a row. */
#define DENOISE_LANES 16
/* Pixels between the middles of cells that keep their light: from the largest, halved down to the smallest, so many times. Noise
   of a cell's light at which half of the difference goes back; pixels between cells that share light of rare rays. Moved by: bias
   of blocks, and noise. */
#define BALANCE_RARE 16
#define BALANCE_LARGEST 64
#define BALANCE_SMALLEST 8
#define BALANCE_PASSES 2
#define BALANCE_NOISE 0.025

/* -- pixels that are judged: draw.c -------------------------------------------------------------- */

/* The part of the mixture that is by light, and the part of that by the difference of two pictures. Moved by: pictures
   whose judge keeps its promise (spec/knob_spec.lua with YLM_SPEC=long). */
#define DRAW_LIGHT 0.5
#define DRAW_CHANGE 0.25
/* Random numbers of the draw. */
#define DRAW_STREAM 0x64726177u

#endif

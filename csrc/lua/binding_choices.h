/*
** binding_choices.h - the words of options, each list once, those of an enum in its order. Functions of C look words up in
** them; lua/ylm asks for them by core.choices(name). Private to csrc/lua.
*/
#ifndef YLM_LUA_CHOICES_H
#define YLM_LUA_CHOICES_H

#include "ylm_base.h"

/* Each X(name, words) is the list ylmL_name_choices, which NULL ends. */
#define YLML_CHOICES(X)                                                                            \
  X(channels, "luminance", "rgb")                                                                  \
  X(cie_sky, "overcast", "clear", "partly cloudy")                                                 \
  X(clamp, "none", "distance", "geometry", "whole")                                                \
  X(dash, "solid", "dashed", "dotted")                                                             \
  X(difference, "absolute", "signed", "relative")                                                  \
  X(dtype, "float", "double")                                                                      \
  X(emit_radius, "density", "angle", "fixed", "footprint", "neighbours")                           \
  X(filter, "box", "linear", "lanczos")                                                            \
  X(gather_derivatives, "cells", "points")                                                         \
  X(gloss, "matte", "sh", "auto", "rays")                                                          \
  X(grid_form, "adaptive_grid", "uniform_grid")                                                    \
  X(horizon, "none", "paper", "gate")                                                              \
  X(interpolation, "hermite", "taylor", "linear")                                                  \
  X(lamp_shape, "point", "sphere", "disk", "rectangle", "polygon", "sun")                          \
  X(legend, "none", "top right", "top left", "bottom right", "bottom left")                        \
  X(mapping, "latlong", "angular", "cube")                                                         \
  X(marker, "none", "cross", "plus", "square", "circle", "diamond")                                \
  X(measure, "coefficients", "irradiance")                                                         \
  X(metric, "absolute", "relative")                                                                \
  X(metric_channels, "luminance", "rgb", "none")                                                   \
  X(near_far, "both", "near", "far")                                                               \
  X(opening, "point", "sphere", "disk", "rectangle")                                               \
  X(outside, "clamp", "nan")                                                                       \
  X(path_strategy, "both", "lights", "material")                                                   \
  X(precision, "half", "float", "byte", "few")                                                     \
  X(shading, "pixel", "vertex")                                                                    \
  X(side, "front", "back")                                                                         \
  X(sides, "auto", "both", "front", "back")                                                        \
  X(slice, "cosine", "bare", "fit")                                                                \
  X(sphere_strategy, "cone", "receiver", "mis")                                                    \
  X(subset, "all", "interleaved", "stochastic")                                                    \
  X(sums, "merged", "forward", "reversed")                                                         \
  X(up, "z", "y")                                                                                  \
  X(virtual_method, "hvl", "vpl", "vsl", "vsgl")                                                   \
  X(visibility, "none", "pixel", "vertex", "rays")                                                 \
  X(weight, "transfer", "cosine")                                                                  \
  X(wrap, "repeat", "mirror", "clamp")

/* Each X(name, list) is such a list too, of the names that a header of C lists. */
#define YLML_LISTS(X)                                                                              \
  X(isa, YLM_ISA_LIST)                                                                             \
  X(quantity, YLM_QUANTITY_LIST)                                                                   \
  X(sh_exp, YLM_SH_EXP_METHOD_LIST)                                                                \
  X(sh_method, YLM_SH_METHOD_LIST)                                                                 \
  X(sh_product, YLM_SH_PRODUCT_METHOD_LIST)                                                        \
  X(shadow_product, YLM_SHADOW_PRODUCT_LIST)                                                       \
  X(tone, YLM_TONE_LIST)                                                                           \
  X(colourmap, YLM_COLOURMAP_LIST)

#define X(name, ...) extern const char *const ylmL_##name##_choices[];
YLML_CHOICES(X)
YLML_LISTS(X)
#undef X

#endif

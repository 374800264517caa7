/* Reads and writes sixteen bytes an item: how fast the device's memory is. */
#version 450
#extension GL_GOOGLE_include_directive : require
#include "ylm.glsl"

layout(set = 0, binding = 0) readonly buffer In { vec4 source[]; };
layout(set = 0, binding = 1) writeonly buffer Out { vec4 target[]; };
PUSH {
  uint first;
  uint n;
};

void main() {
  uint i = ylm_item(first);
  if (i < n) target[i] = source[i];
}

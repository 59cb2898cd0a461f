// Gamut mapping into sRGB and its transfer function; src/gamut.rs explains the former. The constants above this line
// are those of the crate. CONE_SLOPES has the derivatives of the cone responses by the luminances of red, green and
// blue in columns.

vec3 cone_roots(vec3 colour) {
  vec3 cones = CONE_SLOPES * colour;
  return sign(cones) * pow(abs(cones), vec3(1.0 / 3.0));
}

// An edge of the displayable colours, where one component is fixed: keeps the nearest point so far.
void nearest_on_edge(float fixed_slope_c, float fixed_slope_h, vec2 varying_slope, vec2 remaining_slope, vec2 target,
                     float level, float varying_limit, float remaining_limit, inout float least, inout float best_along,
                     inout float best_level, int edge, inout int best_edge) {
  float rest = 1.0 - level;
  float from = max(rest - remaining_limit, 0.0);
  float to = min(rest, varying_limit);
  if (from > to) return;
  vec2 offset = target - vec2(fixed_slope_c, fixed_slope_h) * level - remaining_slope * rest;
  vec2 along_edge = varying_slope - remaining_slope;
  float along = clamp(dot(offset, along_edge) / dot(along_edge, along_edge), from, to);
  vec2 residual = offset - along * along_edge;
  float distance = dot(residual, residual);
  if (distance < least) {
    least = distance;
    best_along = along;
    best_level = level;
    best_edge = edge;
  }
}

vec3 nearest_on_boundary(vec3 chroma_slopes, vec3 hue_slopes, vec2 target, vec3 limits) {
  float least = 1e30;
  float along = 0.0;
  float level = 0.0;
  int edge = 0;
  vec2 red = vec2(chroma_slopes.r, hue_slopes.r);
  vec2 green = vec2(chroma_slopes.g, hue_slopes.g);
  vec2 blue = vec2(chroma_slopes.b, hue_slopes.b);
  for (int side = 0; side < 2; side++) {
    vec3 levels = side == 0 ? vec3(0.0) : limits;
    nearest_on_edge(red.x, red.y, green, blue, target, levels.r, limits.g, limits.b, least, along, level, 0, edge);
    nearest_on_edge(green.x, green.y, blue, red, target, levels.g, limits.b, limits.r, least, along, level, 1, edge);
    nearest_on_edge(blue.x, blue.y, red, green, target, levels.b, limits.r, limits.g, least, along, level, 2, edge);
  }
  float remaining = 1.0 - level - along;
  if (edge == 0) return vec3(level, along, remaining);
  if (edge == 1) return vec3(remaining, level, along);
  return vec3(along, remaining, level);
}

vec3 displayable(vec3 colour) {
  if (all(greaterThanEqual(colour, vec3(0.0))) && all(lessThanEqual(colour, vec3(1.0)))) return colour;
  vec3 components = colour * PRIMARY_LUMINANCES;
  float luminance = components.r + components.g + components.b;
  if (luminance <= 0.0) return vec3(0.0);
  if (luminance >= 1.0) return vec3(1.0);
  components /= luminance;
  vec3 limits = PRIMARY_LUMINANCES / luminance;

  // Where the straight line to grey enters the gamut.
  vec3 grey = PRIMARY_LUMINANCES;
  vec3 below = mix(vec3(1.0), grey / max(grey - components, vec3(1e-6)), lessThan(components, vec3(0.0)));
  vec3 above = mix(vec3(1.0), (limits - grey) / max(components - grey, vec3(1e-6)), greaterThan(components, limits));
  vec3 fractions = min(below, above);
  vec3 mapped = max(grey + min(fractions.r, min(fractions.g, fractions.b)) * (components - grey), vec3(0.0));

  vec3 wanted = cone_roots(components);
  vec2 hue = normalize(vec2(dot(ROOTS_TO_A, wanted), dot(ROOTS_TO_B, wanted)));
  vec3 chroma_weights = hue.x * ROOTS_TO_A + hue.y * ROOTS_TO_B;
  vec3 hue_weights = HUE_WEIGHT * (hue.x * ROOTS_TO_B - hue.y * ROOTS_TO_A);
  for (int step = 0; step < STEPS; step++) {
    vec3 roots = cone_roots(mapped);
    vec3 root_slopes = 1.0 / (3.0 * roots * roots);
    vec3 chroma_slopes = (chroma_weights * root_slopes) * CONE_SLOPES;
    vec3 hue_slopes = (hue_weights * root_slopes) * CONE_SLOPES;
    vec3 change = wanted - roots;
    vec2 target = vec2(dot(chroma_weights, change) + dot(chroma_slopes, mapped),
                       dot(hue_weights, change) + dot(hue_slopes, mapped));
    mapped = nearest_on_boundary(chroma_slopes, hue_slopes, target, limits);
  }
  return clamp(mapped / PRIMARY_LUMINANCES * luminance, 0.0, 1.0);
}

float encode_srgb(float linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1.0 / 2.4) - 0.055;
}

// The colour of a display for linear sRGB.
vec3 display(vec3 colour) {
  vec3 shown = displayable(colour);
  return vec3(encode_srgb(shown.r), encode_srgb(shown.g), encode_srgb(shown.b));
}

// Luminance above the knee is compressed, with a continuous slope.
vec3 filmic(vec3 light) {
  float luminance = dot(PRIMARY_LUMINANCES, light);
  if (luminance <= KNEE) return light;
  return light * ((1.0 - (1.0 - KNEE) * (1.0 - KNEE) / (luminance + 1.0 - 2.0 * KNEE)) / luminance);
}

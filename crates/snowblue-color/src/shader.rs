//! Tone curve and display of linear light as a shader in GLSL, with the constants of this crate.

use crate::gamut::{CONE_SLOPES, HUE_WEIGHT, PRIMARY_LUMINANCES, STEPS};
use crate::matrix::Vector;
use crate::oklab::ROOTS_TO_LAB;
use crate::tone::KNEE;

/// GLSL ES 3.0 of two functions, up to single precision. `vec3 display(vec3 colour)` gives the code values of linear
/// sRGB for a display, those of [`Srgb8::encode`](crate::Srgb8::encode) of the
/// [`displayable`](crate::LinearRgb::displayable) colour. `vec3 filmic(vec3 light)` comes before it. It is the curve
/// [`Filmic`](crate::ToneCurve::Filmic).
#[must_use]
pub fn display_glsl() -> String {
    let [red, green, blue] = CONE_SLOPES.map(numbers);
    let [_, to_a, to_b] = ROOTS_TO_LAB.map(numbers);
    format!(
        "const vec3 PRIMARY_LUMINANCES = vec3({});\n\
         const mat3 CONE_SLOPES = mat3({red}, {green}, {blue});\n\
         const vec3 ROOTS_TO_A = vec3({to_a});\n\
         const vec3 ROOTS_TO_B = vec3({to_b});\n\
         const float HUE_WEIGHT = {HUE_WEIGHT:?};\n\
         const int STEPS = {STEPS};\n\
         const float KNEE = {KNEE:?};\n\
         {}",
        numbers(PRIMARY_LUMINANCES),
        include_str!("display.glsl"),
    )
}

/// Numbers of single precision and a little more.
fn numbers([a, b, c]: Vector) -> String {
    format!("{a:.9}, {b:.9}, {c:.9}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_constants_of_the_shader_are_those_of_the_crate() {
        let shader = display_glsl();
        for line in [
            "const vec3 PRIMARY_LUMINANCES = vec3(0.212639006, 0.715168679, 0.072192315);",
            "const vec3 ROOTS_TO_A = vec3(1.977998495, -2.428592205, 0.450593710);",
            "const float HUE_WEIGHT = 4.0;",
            "const int STEPS = 2;",
            "const float KNEE = 0.8;",
        ] {
            assert!(shader.contains(line), "{shader}");
        }
    }
}

//! Prints pressed into a surface of heights: holes of poles and prints of boots.
//!
//! A print changes heights by a displacement: down within its outline, and up on a rim around it. Where prints overlap,
//! the deepest and the highest displacement add up.

use std::f64::consts::TAU;

use glam::DVec2;

/// Corners of the outline of a boot.
const OUTLINE_CORNERS: u16 = 48;

/// A print.
#[derive(Debug, Clone, PartialEq)]
pub struct Imprint {
    /// Its middle, in m.
    centre_m: DVec2,
    kind: ImprintKind,
    wall: Wall,
    /// Radius of the circle around its middle outside of which the print changes no height, in m.
    reach_m: f64,
}

/// The sides of a print.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wall {
    /// Distance from the outline inwards to the place where the print reaches its depth, in m.
    pub width_m: f64,
    /// Height of the snow that was pushed up at the outline, in m.
    pub rim_m: f64,
    /// Distance from the outline outwards to where the rim ends, in m.
    pub rim_width_m: f64,
}

/// The object that made a print.
#[derive(Debug, Clone, PartialEq)]
pub enum ImprintKind {
    /// A pole.
    Hole {
        /// Radius at the surface, in m.
        radius_m: f64,
        /// Depth below the surface, in m.
        depth_m: f64,
    },
    /// A boot.
    Footprint(Sole),
}

/// The sole of a boot, and the depth of its print.
#[derive(Debug, Clone, PartialEq)]
pub struct Sole {
    /// Unit vector from the heel to the toe.
    pub(crate) heading: DVec2,
    /// Length of the boot, in m.
    pub(crate) length_m: f64,
    /// Depth of the print at the heel and at the toe, in m.
    pub(crate) depths_m: [f64; 2],
    /// Depth of the grooves of the sole, which stand up in the print, in m.
    pub(crate) tread_m: f64,
    /// The outline from heel to toe and back, along and across the boot, in m from its middle.
    outline_m: Vec<DVec2>,
}

/// Which foot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Foot {
    /// The left foot.
    Left,
    /// The right foot.
    Right,
}

impl Imprint {
    /// A print around a middle, in m.
    pub fn new(centre_m: DVec2, kind: ImprintKind, wall: Wall) -> Self {
        let outline_m = match &kind {
            ImprintKind::Hole { radius_m, .. } => *radius_m,
            ImprintKind::Footprint(sole) => sole.outline_m.iter().map(|corner| corner.length()).fold(0.0, f64::max),
        };
        let rim_m = if wall.rim_m > 0.0 { wall.rim_width_m } else { 0.0 };
        Self { centre_m, kind, wall, reach_m: outline_m + rim_m }
    }

    /// Its middle, in m.
    pub(crate) fn centre_m(&self) -> DVec2 {
        self.centre_m
    }

    /// Radius of the circle around its middle outside of which the print changes no height, in m.
    pub(crate) fn reach_m(&self) -> f64 {
        self.reach_m
    }

    /// Greatest distance of a mesh from the print, in m.
    pub(crate) fn tolerance_m(&self) -> f64 {
        match &self.kind {
            ImprintKind::Hole { radius_m, .. } => radius_m / 25.0,
            ImprintKind::Footprint(sole) => sole.length_m / 300.0,
        }
    }

    /// Size of the greatest mesh cells that cannot miss a part of the print, in m.
    pub(crate) fn coarsest_m(&self) -> f64 {
        match &self.kind {
            ImprintKind::Hole { radius_m, .. } => 0.5 * radius_m,
            ImprintKind::Footprint(sole) => sole.length_m / 64.0,
        }
    }

    /// Height by which the print raises the surface at a point, in m; negative within the print.
    pub(crate) fn displacement_m(&self, point_m: DVec2) -> f64 {
        let offset_m = point_m - self.centre_m;
        if offset_m.length_squared() >= self.reach_m * self.reach_m {
            return 0.0;
        }
        let (inside_m, depth_m) = match &self.kind {
            ImprintKind::Hole { radius_m, depth_m } => (radius_m - offset_m.length(), *depth_m),
            ImprintKind::Footprint(sole) => {
                let on_sole_m = DVec2::new(offset_m.dot(sole.heading), offset_m.dot(-sole.heading.perp()));
                (sole.inside_m(on_sole_m), sole.depth_m(on_sole_m))
            }
        };
        self.wall.displacement_m(inside_m, depth_m)
    }
}

/// Height by which some prints raise the surface at a point, in m.
pub(crate) fn displacement_m<'a>(imprints: impl IntoIterator<Item = &'a Imprint>, point_m: DVec2) -> f64 {
    let (mut lowest_m, mut highest_m) = (0.0f64, 0.0f64);
    for imprint in imprints {
        let displacement_m = imprint.displacement_m(point_m);
        lowest_m = lowest_m.min(displacement_m);
        highest_m = highest_m.max(displacement_m);
    }
    lowest_m + highest_m
}

impl Wall {
    /// The displacement at a distance inwards from the outline.
    fn displacement_m(&self, inside_m: f64, depth_m: f64) -> f64 {
        if inside_m >= self.width_m {
            return -depth_m;
        }
        if inside_m >= 0.0 {
            return self.rim_m - (self.rim_m + depth_m) * inside_m / self.width_m;
        }
        let outwards = -inside_m / self.rim_width_m;
        // Falls off without a kink at its foot.
        if outwards < 1.0 { self.rim_m * (1.0 - outwards).powi(2) * (1.0 + 2.0 * outwards) } else { 0.0 }
    }
}

impl Sole {
    /// A boot of a length, with the outline of a foot.
    pub fn new(heading_deg: f64, length_m: f64, depths_m: [f64; 2], tread_m: f64, foot: Foot) -> Self {
        let mirror = match foot {
            Foot::Right => 1.0,
            Foot::Left => -1.0,
        };
        // The corners run along the right side and back along the left side. They are denser at the ends.
        let corner = |number: u16| {
            let along = 0.5 - 0.5 * (TAU * f64::from(number) / f64::from(OUTLINE_CORNERS)).cos();
            let side = if 2 * number < OUTLINE_CORNERS { 1.0 } else { -1.0 };
            length_m * DVec2::new(along - 0.5, mirror * (side * half_width(along) + bend(along)))
        };
        Self {
            heading: DVec2::from_angle(heading_deg.to_radians()),
            length_m,
            depths_m,
            tread_m,
            outline_m: (0..OUTLINE_CORNERS).map(corner).collect(),
        }
    }

    /// Distance from the outline to a point of the sole, positive inside (the distance to a polygon).
    fn inside_m(&self, point: DVec2) -> f64 {
        let (mut nearest, mut is_inside) = (f64::INFINITY, false);
        let mut before = self.outline_m[self.outline_m.len() - 1];
        for &corner in &self.outline_m {
            let (edge, offset) = (corner - before, point - before);
            let along = (offset.dot(edge) / edge.length_squared()).clamp(0.0, 1.0);
            nearest = nearest.min((offset - edge * along).length_squared());
            let crosses = (before.y > point.y) != (corner.y > point.y);
            if crosses && offset.x < edge.x * offset.y / edge.y {
                is_inside = !is_inside;
            }
            before = corner;
        }
        if is_inside { nearest.sqrt() } else { -nearest.sqrt() }
    }

    /// Depth of the print below a point of the sole. It changes from the depth at the heel to the depth at the toe
    /// over the middle of the boot, and the tread is subtracted. The grooves of the tread run across the boot as
    /// chevrons, 16 over its length. The width of a groove is a third of the distance between two grooves.
    fn depth_m(&self, point: DVec2) -> f64 {
        let [heel_m, toe_m] = self.depths_m;
        let along = point.x / self.length_m + 0.5;
        let wave = (16.0 * TAU * (along + 0.5 * (point.y / self.length_m).abs())).cos();
        heel_m + (toe_m - heel_m) * smooth_step(along, 0.3, 0.7) - self.tread_m * smooth_step(wave, 0.3, 0.7)
    }
}

/// Half the width of a sole at a fraction of its length from the heel, as a fraction of the length.
///
/// The heel and the toe are round; the waist is narrow and the ball wide.
fn half_width(along: f64) -> f64 {
    const HEEL: f64 = 0.13;
    const TOE: f64 = 0.22;
    let round = |distance: f64| (1.0 - (1.0 - distance.min(1.0)).powi(2)).max(0.0).sqrt();
    let side = 0.13 - 0.015 * smooth_step(along, 0.15, 0.4) + 0.065 * smooth_step(along, 0.4, 0.7);
    side * round(along / HEEL) * round((1.0 - along) / TOE)
}

/// Offset of the middle of a right sole to the right, as a fraction of the length: the toe points inwards, to the
/// left.
fn bend(along: f64) -> f64 {
    0.02 * smooth_step(along, 0.3, 0.65) - 0.03 * smooth_step(along, 0.65, 1.0)
}

/// A smooth step from 0 at one place to 1 at another.
fn smooth_step(value: f64, from: f64, to: f64) -> f64 {
    let step = ((value - from) / (to - from)).clamp(0.0, 1.0);
    step * step * (3.0 - 2.0 * step)
}

#[cfg(test)]
mod tests {
    use super::*;

    const WALL: Wall = Wall { width_m: 0.01, rim_m: 0.02, rim_width_m: 0.05 };

    #[test]
    fn a_hole_has_its_depth_a_wall_and_a_rim() {
        let kind = ImprintKind::Hole { radius_m: 0.1, depth_m: 0.4 };
        let hole = Imprint::new(DVec2::new(1.0, 2.0), kind, WALL);
        for (distance_m, expected_m) in
            [(0.0, -0.4), (0.09, -0.4), (0.095, -0.19), (0.1, 0.02), (0.125, 0.01), (0.15, 0.0), (9.0, 0.0)]
        {
            let point_m = hole.centre_m + distance_m * DVec2::from_angle(0.7);
            assert!((hole.displacement_m(point_m) - expected_m).abs() < 1e-12, "{distance_m}");
        }
        assert!((hole.reach_m() - 0.15).abs() < 1e-12);
    }

    #[test]
    fn a_footprint_is_as_long_as_the_boot_and_deeper_where_it_is_told_to_be() {
        let sole = |foot| Sole::new(90.0, 0.3, [0.04, 0.06], 0.0, foot);
        let print = |foot| Imprint::new(DVec2::ZERO, ImprintKind::Footprint(sole(foot)), WALL);
        let (right, left) = (print(Foot::Right), print(Foot::Left));
        // Heading to +y: heel below, toe above.
        assert!((right.displacement_m(DVec2::new(0.0, -0.11)) + 0.04).abs() < 1e-12);
        assert!((right.displacement_m(DVec2::new(0.0, 0.08)) + 0.06).abs() < 1e-12);
        assert!(right.displacement_m(DVec2::new(0.0, -0.151)) > 0.019);
        for k in 0..400u16 {
            let point_m = DVec2::new(f64::from(k % 20) - 9.5, f64::from(k / 20) - 9.5) * 0.02;
            let mirrored_m = point_m * DVec2::new(-1.0, 1.0);
            let difference_m = right.displacement_m(point_m) - left.displacement_m(mirrored_m);
            assert!(difference_m.abs() < 1e-12, "{point_m}");
        }
        // The ball lies to the right of the middle of a right foot, which is at +x.
        let ImprintKind::Footprint(sole) = &right.kind else { panic!("a footprint") };
        let widest = sole.outline_m.iter().map(|corner| corner.y).fold(0.0, f64::max);
        assert!(widest > 0.05 && widest < 0.07, "{widest}");
    }

    #[test]
    fn overlapping_prints_add_their_depth_and_their_rim() {
        let hole =
            |x: f64, depth_m: f64| Imprint::new(DVec2::new(x, 0.0), ImprintKind::Hole { radius_m: 0.1, depth_m }, WALL);
        let both = [hole(0.0, 0.4), hole(0.05, 0.3), hole(0.1, 0.2)];
        assert!((displacement_m(&both, DVec2::new(0.04, 0.0)) + 0.4).abs() < 1e-12, "the deepest");
        let apart = [hole(0.0, 0.4), hole(0.2, 0.3)];
        assert!(
            (displacement_m(&apart, DVec2::new(0.08, 0.0)) - (-0.4 + WALL.displacement_m(-0.02, 0.3))).abs() < 1e-12
        );
    }
}

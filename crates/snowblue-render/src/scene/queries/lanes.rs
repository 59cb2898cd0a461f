//! The questions to [`Objects`] and to a [`SceneQueries`], for four rays at a time. Where objects are few, boxes are asked for all rays at
//! once. All else is asked for one ray after the other. Answers have the bits of those for one ray, but for signs of zeros.

use wide::bytemuck::cast;
use wide::{f32x4, i32x4};

use super::SceneQueries;
use crate::geometry::chord::{Chord, ChordEnd, Exit, Line};
use crate::geometry::lanes::{Hits, LANES, LaneMask, RayPacket4, SurfacePoints4, Vec3x4, in_lane, lanes, lanes_where};
use crate::geometry::ray::{REACH_SHARE, stepped};
use crate::geometry::shape::Shape;
use crate::scene::objects::{Objects, Side};

/// What rays hit first.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Surfaces {
    /// Those that hit anything.
    pub(crate) found: LaneMask,
    /// Index of each one's object.
    pub(crate) objects: i32x4,
    /// The points, and normals on the side from which the rays came.
    pub(crate) places: SurfacePoints4,
    /// Directions of the rays.
    pub(crate) direction: Vec3x4,
}

/// Lines from surface points.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lines {
    /// The points, and outward normals there.
    pub(crate) from: SurfacePoints4,
    /// Unit directions of the paths, none of which goes outwards.
    pub(crate) direction: Vec3x4,
    /// Where the paths end at the latest, in m.
    pub(crate) end_m: f32x4,
}

/// The inside parts of lines, summed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Chords {
    /// Those that have any.
    pub(crate) found: LaneMask,
    /// Those that end within the solid: they have no exit.
    pub(crate) inside: LaneMask,
    /// Lengths inside, in m.
    pub(crate) depth_m: f32x4,
    /// Index of the object that each leaves.
    pub(crate) objects: i32x4,
    /// Exit points, and outward unit normals there.
    pub(crate) exits: SurfacePoints4,
}

impl SurfacePoints4 {
    /// The points moved off the surface as [`off_surface`](crate::geometry::ray::off_surface) does.
    #[inline]
    pub(crate) fn off_surface(&self, reach_m: f32) -> Vec3x4 {
        let point = self.point + self.normal * f32x4::splat(REACH_SHARE * reach_m);
        point.zip(self.normal, stepped)
    }
}

impl Shape {
    /// What some rays hit first beyond their origins and nearer than the limits.
    #[inline]
    fn first_hits(&self, rays: &RayPacket4, which: LaneMask, limits_m: f32x4) -> Option<Hits> {
        if let Self::Cuboid(cuboid) = self {
            return cuboid.first_hits(rays, limits_m);
        }
        let (mut met, mut distance_m, mut places) = ([0.0; LANES], [0.0; LANES], SurfacePoints4::NONE);
        for lane in lanes(which) {
            if let Some(hit) = self.first_hit(&rays.lane(lane), limits_m.as_array()[lane]) {
                met[lane] = f32::from_bits(u32::MAX);
                distance_m[lane] = hit.distance_m;
                places.point.set(lane, hit.point);
                places.normal.set(lane, hit.normal);
            }
        }
        Some(Hits { met: f32x4::new(met), distance_m: f32x4::new(distance_m), places })
    }

    /// Those rays on which it does not lie beyond their origins and nearer than the limits.
    #[inline]
    fn passed_by(&self, rays: &RayPacket4, which: LaneMask, limits_m: f32x4) -> LaneMask {
        if let Self::Cuboid(cuboid) = self {
            return which & !cuboid.on_rays(rays, limits_m);
        }
        lanes_where(which, |lane| !self.occludes(&rays.lane(lane), limits_m.as_array()[lane]))
    }
}

impl Objects {
    /// What some rays hit first.
    fn first_hits(&self, rays: &RayPacket4, which: LaneMask) -> Surfaces {
        let (mut found, mut objects, mut places) = (0, i32x4::ZERO, SurfacePoints4::NONE);
        if let Some(few) = self.few() {
            let mut nearest_m = f32x4::splat(f32::INFINITY);
            for index in few {
                let Some(hits) = self.list()[index].shape.first_hits(rays, which, nearest_m) else { continue };
                nearest_m = hits.met.bitselect(hits.distance_m, nearest_m);
                places = SurfacePoints4::select(hits.met, &hits.places, &places);
                objects = cast::<_, i32x4>(hits.met).bitselect(i32x4::splat(in_lane(index)), objects);
                found |= which & hits.met.to_bitmask();
            }
        } else {
            for lane in lanes(which) {
                if let Some(surface) = self.first_hit(&rays.lane(lane)) {
                    found |= 1 << lane;
                    objects.as_mut_array()[lane] = in_lane(surface.object);
                    places.point.set(lane, surface.point);
                    places.normal.set(lane, surface.normal);
                }
            }
        }
        let away = places.normal.dot(rays.direction).simd_gt(f32x4::ZERO);
        places.normal = places.normal.negated_where(away);
        Surfaces { found, objects, places, direction: rays.direction }
    }

    /// Those rays from one side of a surface on which nothing lies nearer than the limits.
    fn free(&self, rays: &RayPacket4, which: LaneMask, limits_m: f32x4, side: Side) -> LaneMask {
        if let Some(few) = self.few() {
            let hiding = few.filter(|index| self.can_occlude(*index, side));
            return hiding.fold(which, |free, index| match free {
                0 => 0,
                _ => self.list()[index].shape.passed_by(rays, free, limits_m),
            });
        }
        lanes_where(which, |lane| !self.occluded(&rays.lane(lane), limits_m.as_array()[lane], side))
    }
}

impl SceneQueries<'_> {
    /// What some rays from the camera hit first.
    pub(crate) fn camera_hits(&mut self, rays: &RayPacket4, which: LaneMask) -> Surfaces {
        self.statistics.camera_rays += u64::from(which.count_ones());
        self.objects().first_hits(rays, which)
    }

    /// Those rays from one side of a surface on which nothing lies nearer than the limits.
    #[inline]
    pub(crate) fn free(&mut self, (rays, limits_m): (&RayPacket4, f32x4), side: Side, which: LaneMask) -> LaneMask {
        self.statistics.shadow_rays += u64::from(which.count_ones());
        self.objects().free(rays, which, limits_m, side)
    }

    /// The depths of some straight paths through the solid that an object is or belongs to.
    #[inline]
    pub(crate) fn chords(&mut self, object: usize, lines: &Lines, exit: Exit, which: LaneMask) -> Chords {
        let objects = i32x4::splat(in_lane(object));
        if let Some(Shape::Cuboid(cuboid)) = self.objects().convex(object) {
            self.statistics.depth_lines += u64::from(which.count_ones());
            let rays = RayPacket4::new(lines.from.point, lines.direction);
            let span = cuboid.spans(&rays);
            // No line goes outwards: none of them seems to be inside still, by rounding, where it has just left.
            let found = span.met & span.leave_m.simd_gt(f32x4::ZERO) & span.enter_m.simd_lt(lines.end_m);
            return Chords {
                found: which & found.to_bitmask(),
                inside: which & (found & span.leave_m.simd_gt(lines.end_m)).to_bitmask(),
                depth_m: found & (span.leave_m.fast_min(lines.end_m) - span.enter_m.fast_max(f32x4::ZERO)),
                objects,
                exits: SurfacePoints4 { point: rays.at(span.leave_m), normal: span.outward },
            };
        }
        let mut chords = Chords { found: 0, inside: 0, depth_m: f32x4::ZERO, objects, exits: SurfacePoints4::NONE };
        for lane in lanes(which) {
            let line = Line {
                point: lines.from.point.lane(lane),
                normal: lines.from.normal.lane(lane),
                direction: lines.direction.lane(lane),
                end_m: lines.end_m.as_array()[lane],
            };
            if let Some(chord) = self.chord(object, &line, exit) {
                chords.set(lane, &chord);
            }
        }
        chords
    }
}

impl Chords {
    /// Depths in cm, the table's unit; 0 where there is none.
    #[inline]
    pub(crate) fn depth_cm(&self) -> f32x4 {
        self.depth_m * f32x4::splat(100.0)
    }

    fn set(&mut self, lane: usize, chord: &Chord) {
        self.found |= 1 << lane;
        self.depth_m.as_mut_array()[lane] = chord.depth_m;
        match chord.exit {
            ChordEnd::Inside => self.inside |= 1 << lane,
            ChordEnd::Surface { object, point, normal } => {
                self.objects.as_mut_array()[lane] = in_lane(object);
                self.exits.point.set(lane, point);
                self.exits.normal.set(lane, normal);
            }
        }
    }
}

//! Places and orientations of facets: a Poisson process on a surface, without bounds and reproducible.
//!
//! Places are points of the plane of two coordinate axes; the surface faces most along the third axis. The plane is
//! divided into square cells. The sphere of normals is divided into bands between circles of latitude, and the bands
//! into bins of nearly equal solid angle. The facets of a cell and a bin follow from a hash of both. They are ordered
//! by how openly they lie, with the gaps of a Poisson process, so that the open facets come first (Knuth 1997, *The
//! Art of Computer Programming* 2, section 3.4.1). The facets of a footprint with normals in a small region are
//! listed from the few cells and bins that the footprint and the region meet.

use std::f64::consts::{PI, TAU};

use glam::Vec3A;
use snowblue_base::narrow;
use snowblue_transport::rng::split_mix_64;

use super::footprint::{FlatFootprint, other_axes};

/// Mean number of facets in a cell and a bin, if all facets lie open.
const MEAN_COUNT: f64 = 2.0;
/// Step of latitude, in units of the size of the regions of normals.
const STEPS_PER_SIZE: f64 = 0.5;
/// Axes for the latitude and longitude of normals; the last axis is the pole. The axes lie askew, so that no usual
/// surface has its facets at a pole, where bins are narrow wedges.
const BIN_AXES: [Vec3A; 3] = [Vec3A::new(0.8, -0.6, 0.0), Vec3A::new(0.48, 0.64, -0.6), Vec3A::new(0.36, 0.48, 0.8)];
/// Greatest distance from the middle of a bin to its corners, in steps of latitude: 0.87 in the wedges at a pole, and
/// elsewhere half of the diagonal of a square.
const BIN_REACH: f64 = 0.9;
/// Distance of a region from the poles, in units of its size, from which on circles of latitude count as straight,
/// apart from the second order of their curvature.
const STRAIGHT: f64 = 8.0;
/// Least and greatest power of two of the step of latitude, in rad.
const STEP_EXPONENTS: [f64; 2] = [-14.0, -3.0];

/// Facets of a density.
#[derive(Debug, Clone, Copy)]
pub(super) struct FacetField {
    seed: u64,
    /// Facets per area of the plane and solid angle of their normals, in 1/(m² sr).
    density: f64,
    bands: u32,
    /// Side of the cells, in m.
    pub(super) cell_m: f64,
}

/// A facet in a footprint.
#[derive(Debug, Clone, Copy)]
pub(super) struct Facet {
    /// Its place in the disc of the footprint.
    pub(super) on_disc: [f32; 2],
    /// Its unit normal.
    pub(super) normal: Vec3A,
    /// Size relative to the smallest and the largest facet, in [0, 1).
    pub(super) size: f32,
}

/// A point of the surface of an object, in the coordinates of the object, with the axis along which the surface faces
/// most.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub(super) object: usize,
    pub(super) point: [f64; 3],
    pub(super) axis: usize,
}

/// A region of normals: a rectangle about a middle.
#[derive(Debug, Clone, Copy)]
pub(super) struct NormalRegion {
    pub(super) middle: Vec3A,
    /// A unit vector perpendicular to the middle: the direction of the first side of the rectangle.
    pub(super) side: Vec3A,
    /// Half of the extent along the first side and across it, in rad.
    pub(super) half_widths: [f32; 2],
}

/// Bins of a band.
#[derive(Debug, Clone, Copy)]
pub(super) struct BandBins {
    band: u32,
    /// The first bin, the number of bins, and the number of all bins of the band.
    first: u32,
    count: u32,
    all: u32,
    /// Cosine of the colatitude where the band begins, and its change to the end of the band.
    cos_start: f64,
    cos_change: f64,
    /// Probability that none of the facets of a bin lies open.
    empty: f64,
}

impl FacetField {
    /// Facets of a density per area of the plane and solid angle of normals, in 1/(m² sr), to be listed for regions of
    /// normals of about some size in rad.
    pub(super) fn new(density: f64, size_rad: f32, seed: u64) -> Self {
        let [least, greatest] = STEP_EXPONENTS;
        let exponent = (STEPS_PER_SIZE * f64::from(size_rad)).log2().ceil().clamp(least, greatest);
        let step = exponent.exp2();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most π 2¹⁴")]
        let bands = (PI / step).ceil() as u32;
        let step = PI / f64::from(bands);
        let cell_m = (MEAN_COUNT / (density * step * step)).sqrt();
        Self { seed: split_mix_64(seed ^ u64::from(bands)), density, bands, cell_m }
    }

    /// Calls `add` for each facet in a footprint with a normal in a region, and for some facets with other normals,
    /// if the facet belongs to the share `open_share` of facets that lie most open.
    #[inline]
    pub(super) fn list(
        &self,
        (place, footprint): (Place, &FlatFootprint),
        (region, open_share): (&NormalRegion, f32),
        bins: &mut Vec<BandBins>,
        mut add: impl FnMut(&Facet),
    ) {
        self.find_bins(region, open_share, bins);
        let [first, second] = other_axes(place.axis);
        let [x, y] = [place.point[first], place.point[second]];
        let [_, half_height] = footprint.half_width_m.map(f64::from);
        let (shear, half_row) = (f64::from(footprint.shear), f64::from(footprint.half_row_m));
        let seed = split_mix_64(self.seed ^ (3 * place.object + place.axis) as u64);
        for row in cell(y - half_height, self.cell_m)..=cell(y + half_height, self.cell_m) {
            let below = row as f64 * self.cell_m - y;
            let ends = [below.max(-half_height), (below + self.cell_m).min(half_height)].map(|end| shear * end);
            let (left, right) = (ends[0].min(ends[1]) - half_row, ends[0].max(ends[1]) + half_row);
            let row_hash = split_mix_64(seed ^ row.cast_unsigned());
            for column in cell(x + left, self.cell_m)..=cell(x + right, self.cell_m) {
                let hash = split_mix_64(row_hash ^ column.cast_unsigned());
                let corner = [column as f64 * self.cell_m - x, below];
                self.list_cell((hash, corner), footprint, bins, &mut add);
            }
        }
    }

    #[inline]
    fn list_cell(
        &self,
        (hash, corner): (u64, [f64; 2]),
        footprint: &FlatFootprint,
        bins: &[BandBins],
        add: &mut impl FnMut(&Facet),
    ) {
        for band in bins {
            for step in 0..band.count {
                let bin = (band.first + step) % band.all;
                let hash = split_mix_64(hash ^ (u64::from(band.band) << 32 | u64::from(bin)));
                let mut product = uniform(hash);
                let mut facet = hash;
                while product > band.empty {
                    facet = facet.wrapping_add(FACET_STEP);
                    let hash = split_mix_64(facet);
                    product *= uniform(split_mix_64(!hash));
                    let [x, y] = pair(hash);
                    let offset = [corner[0] + f64::from(x) * self.cell_m, corner[1] + f64::from(y) * self.cell_m];
                    let on_disc = footprint.on_disc(offset.map(narrow));
                    if on_disc[0] * on_disc[0] + on_disc[1] * on_disc[1] < 1.0 {
                        let hash = split_mix_64(hash);
                        let [size, _] = pair(split_mix_64(hash));
                        add(&Facet { on_disc, normal: band.normal(bin, pair(hash)), size });
                    }
                }
            }
        }
    }

    /// Finds the bins whose middles lie in a region or near it.
    fn find_bins(&self, region: &NormalRegion, open_share: f32, bins: &mut Vec<BandBins>) {
        bins.clear();
        let step = PI / f64::from(self.bands);
        let [x, y, z] = BIN_AXES.map(|axis| f64::from(axis.dot(region.middle)));
        let (sin_middle, longitude) = (x.hypot(y), y.atan2(x));
        let colatitude = sin_middle.atan2(z);
        let mut half_widths = region.half_widths.map(|half| f64::from(half) + BIN_REACH * step);
        // The sides of the region southwards and eastwards.
        let side = {
            let [side_x, side_y, side_z] = BIN_AXES.map(|axis| f64::from(axis.dot(region.side)));
            let (cos, sin) = if sin_middle > 0.0 { (x / sin_middle, y / sin_middle) } else { (1.0, 0.0) };
            [z * (cos * side_x + sin * side_y) - sin_middle * side_z, cos * side_y - sin * side_x]
        };
        let sides = [side, [-side[1], side[0]]];
        let reach = half_widths[0].hypot(half_widths[1]);
        let from_pole = colatitude.min(PI - colatitude);
        let is_straight = from_pole > STRAIGHT * reach;
        if is_straight {
            // Circles of latitude deviate from their tangent by at most this term.
            half_widths = half_widths.map(|half| half + 0.5 * reach * reach / from_pole);
        }
        // A corner of the rectangle may point north; near a pole, any part of the rectangle may.
        let corner = sides.iter().zip(half_widths).map(|(side, half)| side[0].abs() * half).sum::<f64>();
        let high = if is_straight { corner } else { reach };
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the bands")]
        let band_of = |angle: f64| (angle / step).clamp(0.0, f64::from(self.bands - 1)) as u32;
        for band in band_of(colatitude - high)..=band_of(colatitude + high) {
            let middle = (f64::from(band) + 0.5) * step;
            let south = middle - colatitude;
            let [mut west, mut east] = [-PI, PI];
            if is_straight {
                for (side, half) in sides.iter().zip(half_widths) {
                    let ends = [-half, half].map(|half| (half - south * side[0]) / side[1]);
                    if side[1].abs() > 1e-9 {
                        west = west.max(ends[0].min(ends[1]));
                        east = east.min(ends[0].max(ends[1]));
                    }
                }
                [west, east] = [west, east].map(|end| end / middle.sin());
            } else if sin_middle > reach.sin() && reach < 0.5 * PI {
                east = (reach.sin() / sin_middle).asin() + step / middle.sin();
                west = -east;
            }
            self.add_bins(band, [longitude + west, longitude + east], open_share, bins);
        }
    }

    /// Adds the bins of a band whose middles lie between two longitudes.
    fn add_bins(&self, band: u32, [west, east]: [f64; 2], open_share: f32, bins: &mut Vec<BandBins>) {
        let step = PI / f64::from(self.bands);
        let middle = (f64::from(band) + 0.5) * step;
        let around = (TAU * middle.sin() / step).round().max(1.0);
        let width = TAU / around;
        let [first, last] = [(west / width - 0.5).ceil(), (east / width - 0.5).floor()];
        if last < first {
            return;
        }
        let start = f64::from(band) * step;
        // cos a − cos b without a difference of large numbers.
        let cos_change = -2.0 * middle.sin() * (0.5 * step).sin();
        let mean = -cos_change * width * self.density * self.cell_m * self.cell_m * f64::from(open_share);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "numbers of bins, at most 2π 2¹⁴")]
        let [all, first, count] =
            [around, first.rem_euclid(around), (last - first + 1.0).min(around)].map(|number| number as u32);
        let (empty, cos_start) = ((-mean).exp(), start.cos());
        bins.push(BandBins { band, first, count, all, cos_start, cos_change, empty });
    }
}

impl BandBins {
    /// A normal in a bin, by two numbers in [0, 1).
    #[inline]
    fn normal(&self, bin: u32, [down, along]: [f32; 2]) -> Vec3A {
        let cos = self.cos_start + f64::from(down) * self.cos_change;
        let sin = narrow((1.0 - cos * cos).max(0.0).sqrt());
        let longitude = narrow((f64::from(bin) + f64::from(along)) * (TAU / f64::from(self.all)));
        let (sin_longitude, cos_longitude) = longitude.sin_cos();
        BIN_AXES[0] * (sin * cos_longitude) + BIN_AXES[1] * (sin * sin_longitude) + BIN_AXES[2] * narrow(cos)
    }
}

/// Difference of the hashes of two successive facets, an odd number.
const FACET_STEP: u64 = 0xd1b5_4a32_d192_ed03;

/// A number in [0, 1).
#[inline]
fn uniform(hash: u64) -> f64 {
    const UNIT: f64 = 1.0 / (1u64 << 53) as f64;
    (hash >> 11) as f64 * UNIT
}

/// Two numbers in [0, 1) of 24 binary digits each.
#[inline]
fn pair(hash: u64) -> [f32; 2] {
    const UNIT: f32 = 1.0 / (1u32 << 24) as f32;
    [hash >> 40, (hash >> 8) & 0xff_ffff].map(|digits| digits as f32 * UNIT)
}

/// The cell of a coordinate.
#[inline]
#[expect(
    clippy::cast_possible_truncation,
    reason = "coordinates are at most 10⁵ m, cells no smaller than a wavelength"
)]
fn cell(coordinate_m: f64, cell_m: f64) -> i64 {
    (coordinate_m / cell_m).floor() as i64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrators::sparkle::footprint::Footprint;

    /// The open facets of a footprint with normals within a region, 2·10⁶ per m² and sr.
    fn listed(place: Place, footprint: &Footprint, region: &NormalRegion) -> Vec<Facet> {
        let field = FacetField::new(5e6, 0.01, 5);
        let flat = footprint.flat(place.axis).unwrap();
        let (mut bins, mut facets) = (Vec::new(), Vec::new());
        let across = region.middle.cross(region.side);
        field.list((place, &flat), (region, 0.4), &mut bins, |facet| {
            let [along, aside] = [region.side, across].map(|side| facet.normal.dot(side));
            let [most_along, most_aside] = region.half_widths;
            if along.abs() < most_along && aside.abs() < most_aside && facet.normal.dot(region.middle) > 0.0 {
                facets.push(*facet);
            }
        });
        facets
    }

    fn footprint(size_m: f32, normal: Vec3A) -> Footprint {
        let changes = [Vec3A::new(1.0, 0.2, 0.1), Vec3A::new(-0.3, 1.0, 0.2)].map(|change| change * size_m);
        Footprint::new(Vec3A::new(0.3, 0.6, -0.7).normalize(), 1.0, changes, normal).unwrap()
    }

    /// Counts of facets in 4000 footprints, far apart, are Poisson's: mean and variance are area × solid angle ×
    /// density, within 4 standard errors (of the mean √(m/n), of the variance √((m + 2m²)/n)). Regions are as long as
    /// ten times their width, and turned in many ways.
    #[test]
    fn counts_are_poissons_everywhere_on_the_sphere() {
        let normals = [
            Vec3A::Z,
            BIN_AXES[2],
            -BIN_AXES[2],
            (BIN_AXES[2] + BIN_AXES[0] * 0.05).normalize(),
            (BIN_AXES[2] - BIN_AXES[1] * 0.2).normalize(),
            (BIN_AXES[2] + BIN_AXES[1] * 0.8).normalize(),
            BIN_AXES[0],
            Vec3A::new(-0.5, 0.1, -0.8).normalize(),
        ];
        for (number, middle) in normals.into_iter().enumerate() {
            for half_widths in [[0.01, 0.01], [0.05, 0.008], [0.08, 0.008]] {
                for (axis, size_m, turn) in [(2, 0.01, 0.4_f32), (2, 0.01, 1.2), (2, 0.01, 2.4), (0, 0.1, 0.4)] {
                    let normal = Vec3A::AXES[axis];
                    let footprint = footprint(size_m, normal);
                    let (sin, cos) = turn.sin_cos();
                    let side = middle.any_orthonormal_pair().0 * cos + middle.any_orthonormal_pair().1 * sin;
                    let region = NormalRegion { middle, side, half_widths };
                    let trials = if size_m > 0.05 { 400 } else { 4000 };
                    let counts = (0..trials).map(|trial| {
                        let point = [3.7 * f64::from(trial), -1.3 * f64::from(trial), 0.7 * f64::from(trial)];
                        listed(Place { object: 0, point, axis }, &footprint, &region).len() as f64
                    });
                    let counts: Vec<f64> = counts.collect();
                    let count = counts.len() as f64;
                    let mean = counts.iter().sum::<f64>() / count;
                    let variance = counts.iter().map(|one| (one - mean).powi(2)).sum::<f64>() / (count - 1.0);
                    // ∫ dx dy/√(1 − x² − y²) over the rectangle to the second order.
                    let [a, b] = half_widths.map(f64::from);
                    let solid_angle = 4.0 * a * b * (1.0 + (a * a + b * b) / 6.0);
                    let expected = 2e6 * solid_angle * f64::from(footprint.area_m2);
                    let error = 4.0 * (expected / count).sqrt();
                    let place = format!("{number} {axis} {turn} {half_widths:?}");
                    assert!((mean - expected).abs() < error, "{place}: {mean} {expected}");
                    let error = 4.0 * ((expected + 2.0 * expected * expected) / count).sqrt();
                    assert!((variance - expected).abs() < error, "{place}: {variance} {expected}");
                }
            }
        }
    }

    /// Overlapping footprints have equal facets in their intersection; another object has other facets.
    #[test]
    fn facets_stay_where_they_are() {
        let region = NormalRegion { middle: Vec3A::Z, side: Vec3A::X, half_widths: [0.1, 0.1] };
        let (wide, small) = (footprint(0.04, Vec3A::Z), footprint(0.02, Vec3A::Z));
        let places = |footprint: &Footprint, x: f64, object: usize| {
            let place = Place { object, point: [x, 0.2, 0.0], axis: 2 };
            let point = |facet: Facet| footprint.offset(facet.on_disc) + Vec3A::new(narrow(x), 0.2, 0.0);
            let facets = listed(place, footprint, &region).into_iter();
            facets.map(|facet| (point(facet), facet.normal)).collect::<Vec<_>>()
        };
        let all = places(&wide, 1.0, 4);
        let part = places(&small, 1.004, 4);
        assert!(part.len() > 20 && all.len() > part.len());
        for (point, normal) in part {
            // Rounding of single precision at 1 m.
            assert!(all.iter().any(|(other, same)| other.distance(point) < 1e-6 && *same == normal), "{point}");
        }
        assert!(places(&wide, 1.0, 5).iter().all(|facet| !all.contains(facet)));
    }
}

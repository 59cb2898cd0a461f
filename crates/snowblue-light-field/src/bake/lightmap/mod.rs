//! The light of all snow in one texture: a lightmap.
//!
//! 1. `charts`: each surface is cut into parts that are laid flat.
//! 2. `packing`: the rectangles about them are packed into a square of texels, all at one scale.
//! 3. `texels`: the light field is read at the place that each texel shows. In the gutter around a chart that is the
//!    nearest place of its edge.
//! 4. Texels between the charts get the light of the nearest ones, so that a program that compresses the texture or
//!    makes smaller levels of it mixes in nothing black.

mod charts;
mod flat_surface;
mod packing;
mod rectangle;
mod texels;

#[cfg(test)]
mod tests;

use glam::DVec2;
use rayon::prelude::*;
use snowblue_color::LinearRgb;
use snowblue_geometry::ray::narrow;
use snowblue_scene::film::sensor::Sensor;

use crate::LightField;

use charts::Chart;
pub(super) use charts::Charts;
pub(super) use flat_surface::FlatSurface;
pub(super) use packing::Packing;
use packing::{GUTTER, pack, with_gutter};
use texels::{ChartTexels, place};

/// Texels that are read between two reports.
const TEXELS_PER_REPORT: usize = 1 << 15;
/// Columns and rows of a lightmap.
pub const LIGHTMAP_SIZES: std::ops::RangeInclusive<u32> = 64..=4096;

/// What leaves the surface of all snow, as a square texture.
#[derive(Debug, Clone, PartialEq)]
pub struct Lightmap {
    /// Columns and rows.
    pub size: u32,
    /// Side of a texel on a surface that lies flat, in m.
    pub texel_m: f64,
    /// Exitance as linear sRGB in W/m², row by row from v = 0: red, green and blue.
    pub texels: Vec<[f32; 3]>,
}

/// More charts than fit into a lightmap.
pub(super) struct TooManyCharts {
    pub(super) charts: usize,
    /// A size that is enough, if there is one.
    pub(super) enough: Option<u32>,
}

/// Packs the charts of all surfaces.
///
/// # Errors
///
/// When they do not fit.
pub(super) fn packed(surfaces: &[FlatSurface], size: u32) -> Result<Packing, TooManyCharts> {
    let extents_m: Vec<DVec2> =
        surfaces.iter().flat_map(|surface| &surface.charts.list).map(|chart| chart.extent_m).collect();
    pack(&extents_m, size).ok_or_else(|| {
        let (least, greatest) = LIGHTMAP_SIZES.into_inner();
        let doublings = std::iter::successors(Some(least), |size| size.checked_mul(2));
        let sizes = doublings.take_while(|size| *size < greatest).chain([greatest]);
        let enough = sizes.filter(|larger| *larger > size).find(|larger| pack(&extents_m, *larger).is_some());
        TooManyCharts { charts: extents_m.len(), enough }
    })
}

/// The texture coordinates of the vertices of each surface.
pub(super) fn coordinates(surfaces: &[FlatSurface], packing: &Packing, size: u32) -> Vec<Vec<[f32; 2]>> {
    let mut corners = packing.corners.iter();
    let of_surface = |surface: &FlatSurface| {
        let mut coordinates = vec![[0.0; 2]; surface.charts.flat_m.len()];
        for (chart, corner) in surface.charts.list.iter().zip(&mut corners) {
            let corner = DVec2::from(corner.map(|texel| f64::from(texel + GUTTER)));
            for vertex in chart.triangles.iter().flat_map(|triangle| surface.triangles[*triangle as usize]) {
                let at = corner + surface.charts.flat_m[vertex as usize] * packing.texels_per_m;
                coordinates[vertex as usize] = (at / f64::from(size)).to_array().map(narrow);
            }
        }
        coordinates
    };
    surfaces.iter().map(of_surface).collect()
}

/// Reads the light field at all texels. It reports how many texels are done, and how many there are.
pub(super) fn read(
    surfaces: &[FlatSurface],
    (packing, size): (&Packing, u32),
    field: &LightField,
    sensor: &Sensor,
    report: impl Fn(u64, u64),
) -> Lightmap {
    let mut shown: Vec<Option<[f32; 3]>> = vec![None; size as usize * size as usize];
    let charts = surfaces.iter().flat_map(|surface| surface.charts.list.iter().map(move |chart| (surface, chart)));
    let scale = packing.texels_per_m;
    let area = |chart: &Chart| with_gutter(chart.extent_m, scale).map(u64::from).into_iter().product::<u64>();
    let total: u64 = surfaces.iter().flat_map(|surface| &surface.charts.list).map(area).sum();
    let mut before = 0;
    for ((surface, chart), [left, top]) in charts.zip(&packing.corners) {
        report(before, total);
        let Some(body) = field.of_object(surface.object) else { continue };
        let corners = |triangle: u32| surface.charts.corners(surface.triangles[triangle as usize], scale);
        let [columns, rows] = with_gutter(chart.extent_m, scale);
        let texels = ChartTexels::of(&chart.triangles, [columns, rows], corners, &|| report(before, total));
        let read = |(at, triangle): ([u32; 2], u32)| {
            let surface_point = place(surface, triangle, &corners(triangle), at);
            let exitance = body.exitance(surface_point.point, surface_point.normal);
            let LinearRgb { r, g, b } = LinearRgb::from_xyz(sensor.xyz(&exitance));
            (at, [r, g, b].map(narrow))
        };
        for (number, part) in (0..).zip(texels.shown().chunks(TEXELS_PER_REPORT)) {
            let read: Vec<([u32; 2], [f32; 3])> = part.par_iter().copied().map(read).collect();
            for ([column, row], exitance) in read {
                shown[((top + row) * size + left + column) as usize] = Some(exitance);
            }
            report(before + number * TEXELS_PER_REPORT as u64 + part.len() as u64, total);
        }
        before += area(chart);
    }
    report(total, total);
    Lightmap { size, texel_m: packing.texels_per_m.recip(), texels: spread(shown, size) }
}

/// Fills texels without a value with that of the nearest one, by steps to the four neighbours.
fn spread(mut texels: Vec<Option<[f32; 3]>>, size: u32) -> Vec<[f32; 3]> {
    let size = size as usize;
    let mut edge: Vec<usize> = (0..texels.len()).filter(|texel| texels[*texel].is_some()).collect();
    while !edge.is_empty() {
        let mut next = Vec::new();
        for texel in edge {
            let (column, value) = (texel % size, texels[texel]);
            let neighbours = [
                (column > 0).then(|| texel - 1),
                (column + 1 < size).then(|| texel + 1),
                texel.checked_sub(size),
                Some(texel + size).filter(|texel| *texel < texels.len()),
            ];
            for neighbour in neighbours.into_iter().flatten() {
                if texels[neighbour].is_none() {
                    texels[neighbour] = value;
                    next.push(neighbour);
                }
            }
        }
        edge = next;
    }
    texels.into_iter().map(Option::unwrap_or_default).collect()
}

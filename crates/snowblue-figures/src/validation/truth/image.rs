//! Small renderings, their cells, and the parts of a block.

use std::time::Instant;

use snowblue_color::Xyz;
use snowblue_render::scene::film::ImageSize;

use snowblue_render::render::render_all;
use snowblue_render::{Film, Integrator};

/// Side of a rendering, in pixels.
pub(super) const SIDE: u32 = 16;
/// Side of a cell, in pixels. Means over cells are compared, since single pixels are too noisy.
const CELL: u32 = 4;

/// A rendering and its time.
pub(super) struct TimedImage {
    pub(super) pixels: Vec<Xyz>,
    pub(super) seconds: f64,
}

/// A part of a block seen straight on.
pub(super) struct Part {
    pub(super) name: &'static str,
    /// Ranges of columns, each from a first to before a last pixel.
    columns: [[u32; 2]; 2],
}

pub(super) const PARTS: [Part; 2] = [
    Part { name: "middle", columns: [[4, 8], [8, 12]] },
    Part { name: "left and right eighth", columns: [[1, 3], [13, 15]] },
];
/// Rows of all parts.
const PART_ROWS: [u32; 2] = [4, 12];

pub(super) fn render_timed(integrator: &Integrator) -> TimedImage {
    let start = Instant::now();
    let pixels = render_all(integrator, &|_| {}).film.pixels().to_vec();
    TimedImage { pixels, seconds: start.elapsed().as_secs_f64() }
}

pub(super) fn film(pixels: &[Xyz]) -> Film {
    Film::new(ImageSize { width: SIDE, height: SIDE }, pixels.to_vec())
}

/// The mean of each cell.
pub(super) fn cells(pixels: &[Xyz]) -> Vec<Xyz> {
    let mut cells = vec![Xyz::default(); ((SIDE / CELL) * (SIDE / CELL)) as usize];
    for (pixel, xyz) in pixels.iter().enumerate() {
        cells[cell_of(pixel)] = cells[cell_of(pixel)] + *xyz * f64::from(CELL * CELL).recip();
    }
    cells
}

/// The cell of a pixel.
pub(super) fn cell_of(pixel: usize) -> usize {
    let (side, cell) = (SIDE as usize, CELL as usize);
    pixel / side / cell * (side / cell) + pixel % side / cell
}

impl Part {
    /// Mean luminance of the part.
    pub(super) fn luminance(&self, pixels: &[Xyz]) -> f64 {
        let inside = |x: u32, y: u32| {
            (PART_ROWS[0]..PART_ROWS[1]).contains(&y)
                && self.columns.iter().any(|columns| (columns[0]..columns[1]).contains(&x))
        };
        let chosen = (0..SIDE * SIDE).filter(|pixel| inside(pixel % SIDE, pixel / SIDE));
        let luminances: Vec<f64> = chosen.map(|pixel| pixels[pixel as usize].y).collect();
        luminances.iter().sum::<f64>() / luminances.len() as f64
    }
}

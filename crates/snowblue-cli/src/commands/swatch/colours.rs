//! The colours of all swatches. Each snow is solved once, for all its thicknesses, angles and illuminants.

use snowblue_color::Colorimeter;
use snowblue_figures::Cell;
use snowblue_transport::ordinates::{Fluxes, OrdinatesOptions, solve_each};
use snowblue_transport::sample::SnowSample;
use snowblue_transport::slab::{Incidence, Slab};

use super::axis::{Axis, Subject};
use crate::options::{ColorOptions, check_transmits};
use crate::output::Failure;
use crate::output::color_row::ColorRow;

/// The distinct snow, thicknesses and incidences of the subjects.
#[derive(Default)]
struct Cases {
    samples: Vec<SnowSample>,
    thicknesses_cm: Vec<f64>,
    incidences: Vec<Incidence>,
}

/// Indices of a subject's snow, thickness and incidence.
struct Case {
    sample: usize,
    thickness: usize,
    incidence: usize,
}

/// Row and column of a swatch.
#[derive(Clone, Copy)]
struct Position {
    row: usize,
    column: usize,
}

impl Cases {
    fn case(&mut self, subject: &Subject) -> Case {
        Case {
            sample: index_of(&mut self.samples, subject.sample),
            thickness: index_of(&mut self.thicknesses_cm, subject.thickness_cm),
            incidence: index_of(&mut self.incidences, subject.incidence),
        }
    }
}

/// How the subjects of a sheet become colours.
pub(super) struct SheetColours<'s> {
    pub(super) rows: Option<&'s Axis>,
    pub(super) columns: Option<&'s Axis>,
    pub(super) color: &'s ColorOptions,
    pub(super) reflected: bool,
    pub(super) ordinates: OrdinatesOptions,
}

impl SheetColours<'_> {
    /// Colours of subjects, by row and column.
    pub(super) fn of(&self, subjects: &[Vec<Subject>]) -> Result<Vec<Vec<ColorRow>>, Failure> {
        let mut cases = Cases::default();
        let indices: Vec<Vec<Case>> =
            subjects.iter().map(|row| row.iter().map(|subject| cases.case(subject)).collect()).collect();
        check_transmits(&cases.thicknesses_cm, self.reflected)?;
        let slab = Slab {
            sample: subjects[0][0].sample,
            thicknesses_cm: cases.thicknesses_cm,
            incidences: cases.incidences,
            wavelengths_nm: self.color.samples.wavelengths_nm(),
        };
        let solved = solve_each(&cases.samples, &slab, &self.ordinates).map_err(Failure::input)?;
        let colour = |position: Position| {
            let Case { sample, thickness, incidence } = indices[position.row][position.column];
            let fluxes = solved[sample].spectrum(thickness, incidence);
            self.colour(position, &subjects[position.row][position.column], &slab.wavelengths_nm, fluxes)
        };
        let row = |row: usize| -> Result<Vec<ColorRow>, Failure> {
            (0..subjects[row].len()).map(|column| colour(Position { row, column })).collect()
        };
        (0..subjects.len()).map(row).collect()
    }

    fn colour(
        &self,
        position: Position,
        subject: &Subject,
        wavelengths_nm: &[f64],
        fluxes: &[Fluxes],
    ) -> Result<ColorRow, Failure> {
        let value = |fluxes: &Fluxes| if self.reflected { fluxes.reflectance } else { fluxes.transmittance };
        let values: Vec<f64> = fluxes.iter().map(value).collect();
        let steps = [(self.rows, position.row), (self.columns, position.column)];
        let varying = steps.into_iter().filter_map(|(axis, step)| Some((axis?, step)));
        let mut cells: Vec<Cell> = varying
            .filter(|(axis, _)| axis.parameter.column().is_some())
            .map(|(axis, step)| Cell::Word(axis.word(step)))
            .collect();
        cells.push(subject.thickness_cm.into());
        cells.push(Cell::word(subject.incidence.to_string()));
        let colorimeter = Colorimeter::new(self.color.observer, subject.illuminant, wavelengths_nm);
        let colorimeter = colorimeter.map_err(Failure::input)?;
        Ok(ColorRow::of_spectrum(cells, subject.illuminant, &colorimeter, &values))
    }
}

/// The index of a value in a list, appended if it is new.
fn index_of<T: PartialEq>(known: &mut Vec<T>, value: T) -> usize {
    known.iter().position(|other| *other == value).unwrap_or_else(|| {
        known.push(value);
        known.len() - 1
    })
}

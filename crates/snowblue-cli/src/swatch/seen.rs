//! The colours of many subjects, with as few solutions of the equation of transfer as do.

use snowblue_color::Colorimeter;
use snowblue_render::FalseColor;
use snowblue_transport::ordinates::{Fluxes, solve_each};
use snowblue_transport::slab::Slab;

use super::Swatch;
use super::axis::Subject;
use crate::colored::{Colored, wavelengths_nm};
use crate::failure::Failure;
use crate::options::incidence_name;
use crate::report::Cell;

impl Swatch {
    /// Colours of subjects in rows. Equal snow is solved once for all its thicknesses, angles and illuminants.
    pub(super) fn seen(&self, subjects: &[Vec<Subject>]) -> Result<Vec<Vec<Colored>>, Failure> {
        let mut samples = Vec::new();
        let mut slab = Slab {
            sample: subjects[0][0].sample,
            thicknesses_cm: Vec::new(),
            incidences: Vec::new(),
            wavelengths_nm: match self.eye.false_color {
                Some(FalseColor { red_nm, green_nm, blue_nm }) => vec![red_nm, green_nm, blue_nm],
                None => wavelengths_nm(&self.eye.samples),
            },
        };
        let place = |subject: &Subject| {
            let sample = place_of(&mut samples, subject.sample);
            let thickness = place_of(&mut slab.thicknesses_cm, subject.thickness_cm);
            (sample, thickness, place_of(&mut slab.incidences, subject.incidence))
        };
        let places: Vec<(usize, usize, usize)> = subjects.iter().flatten().map(place).collect();
        let solved = solve_each(&samples, &slab, &self.ordinates.options()).map_err(Failure::input)?;
        let mut places = places.into_iter();
        let mut seen = |(row, column): (usize, usize), subject: &Subject| {
            let (sample, thickness, incidence) = places.next().unwrap_or_default();
            let fluxes = &solved[sample][thickness * slab.incidences.len() + incidence];
            self.see((row, column), subject, &slab.wavelengths_nm, fluxes)
        };
        let mut across = |(row, subjects): (usize, &Vec<Subject>)| -> Result<Vec<Colored>, Failure> {
            subjects.iter().enumerate().map(|(column, subject)| seen((row, column), subject)).collect()
        };
        subjects.iter().enumerate().map(&mut across).collect()
    }

    fn see(
        &self,
        (row, column): (usize, usize),
        subject: &Subject,
        wavelengths_nm: &[f64],
        fluxes: &[Fluxes],
    ) -> Result<Colored, Failure> {
        let of = |fluxes: &Fluxes| if self.reflected { fluxes.reflectance } else { fluxes.transmittance };
        let values: Vec<f64> = fluxes.iter().map(of).collect();
        let steps = [(&self.rows, row), (&self.columns, column)];
        let varying = steps.into_iter().filter_map(|(axis, step)| Some((axis.as_ref()?, step)));
        let mut cells: Vec<Cell> = varying
            .filter(|(axis, _)| axis.parameter.column().is_some())
            .map(|(axis, step)| Cell::Word(axis.word(step)))
            .collect();
        cells.push(subject.thickness_cm.into());
        cells.push(Cell::Word(incidence_name(subject.incidence)));
        if self.eye.false_color.is_some() {
            return Ok(Colored::in_false_color(cells, [values[0], values[1], values[2]]));
        }
        let colorimeter = Colorimeter::new(self.eye.observer, subject.illuminant, wavelengths_nm);
        Ok(Colored::seen(cells, subject.illuminant, &colorimeter.map_err(Failure::input)?, &values))
    }
}

/// Where a thing stands among others, which it joins if it is new.
fn place_of<T: PartialEq>(known: &mut Vec<T>, thing: T) -> usize {
    known.iter().position(|other| *other == thing).unwrap_or_else(|| {
        known.push(thing);
        known.len() - 1
    })
}

//! All figures by name.

use crate::error::FigureError;
use crate::figure::Figure;
use crate::{paper, validation};

/// Options of figures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FigureOptions {
    /// Factor on the samples of the path-traced references of `truth`; their noise falls with its square root.
    pub reference_samples: u32,
}

impl Default for FigureOptions {
    fn default() -> Self {
        Self { reference_samples: 1 }
    }
}

/// A figure's name, and how it is made.
#[derive(Debug, Clone, Copy)]
pub struct Recipe {
    /// Name, also of its files.
    pub name: &'static str,
    /// The paper's name of what it redraws; none for figures beyond the paper.
    pub in_paper: Option<&'static str>,
    make: fn(FigureOptions) -> Result<Figure, FigureError>,
}

impl Recipe {
    /// Computes and draws the figure.
    ///
    /// # Errors
    /// If a solution, a table, a colour or a rendering fails.
    pub fn make(&self, options: FigureOptions) -> Result<Figure, FigureError> {
        (self.make)(options)
    }
}

/// All figures in the order of the page: the paper's, then ours.
pub const RECIPES: [Recipe; 17] = [
    Recipe { name: "table1", in_paper: Some("Table 1"), make: |_| paper::table1::figure() },
    Recipe { name: "fig1", in_paper: Some("Fig. 1"), make: |_| paper::renderings::fig1() },
    Recipe { name: "fig2", in_paper: Some("Fig. 2"), make: |_| paper::fig2::figure() },
    Recipe { name: "fig3", in_paper: Some("Fig. 3"), make: |_| paper::fig3::figure() },
    Recipe { name: "fig4", in_paper: Some("Fig. 4"), make: |_| paper::fig4::figure() },
    Recipe { name: "fig5-8", in_paper: Some("Figs. 5–8"), make: |_| paper::fig5_8::figure() },
    Recipe { name: "fig9", in_paper: Some("Fig. 9"), make: |_| paper::renderings::fig9() },
    Recipe { name: "fig10", in_paper: Some("Fig. 10"), make: |_| paper::renderings::fig10() },
    Recipe { name: "fig11", in_paper: Some("Fig. 11"), make: |_| paper::renderings::fig11() },
    Recipe { name: "s1", in_paper: Some("Fig. S1"), make: |_| paper::s1::figure() },
    Recipe { name: "lprime", in_paper: Some("Sidebar"), make: |_| paper::lprime::figure() },
    Recipe { name: "s2", in_paper: Some("Fig. S2"), make: |_| paper::s2::figure() },
    Recipe { name: "simplifications", in_paper: None, make: |_| validation::simplifications::figure() },
    Recipe { name: "water", in_paper: None, make: |_| validation::water::figure() },
    Recipe { name: "albedo", in_paper: None, make: |_| validation::albedo::figure() },
    Recipe { name: "microct", in_paper: None, make: |_| validation::microct::figure() },
    Recipe { name: "truth", in_paper: None, make: |options| validation::truth::figure(options.reference_samples) },
];

/// The recipes of these names, or all if none is given, in the order of [`RECIPES`].
///
/// # Errors
/// If a name is not known.
pub fn recipes(names: &[String]) -> Result<Vec<&'static Recipe>, FigureError> {
    let known = RECIPES.map(|recipe| recipe.name);
    if let Some(name) = names.iter().find(|name| !known.contains(&name.as_str())) {
        return Err(FigureError::UnknownFigure { name: name.clone(), known: known.join(", ") });
    }
    let asked = |recipe: &&Recipe| names.is_empty() || names.iter().any(|name| name == recipe.name);
    Ok(RECIPES.iter().filter(asked).collect())
}

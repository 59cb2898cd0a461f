//! Why a figure cannot be made.

use snowblue_color::ColorError;
use snowblue_database::DatabaseError;
use snowblue_render::{RenderError, SceneError};
use snowblue_transport::TransportError;

/// Why a figure cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum FigureError {
    /// No figure has this name.
    #[error("figure '{name}' is not known; there are {known}")]
    UnknownFigure {
        /// The name that was asked for.
        name: String,
        /// All names, separated by commas.
        known: String,
    },
    /// A solution of the equation of transfer failed.
    #[error(transparent)]
    Transport(#[from] TransportError),
    /// A table or a look-up in it failed.
    #[error(transparent)]
    Database(#[from] DatabaseError),
    /// A colour could not be computed.
    #[error(transparent)]
    Color(#[from] ColorError),
    /// A scene could not be built.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A picture could not be rendered.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A drawing's geometry has no solution.
    #[error("{0}")]
    Geometry(&'static str),
}

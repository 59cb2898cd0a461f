//! From a scene with snow to an image: a spectral path tracer with PCASnow.
//!
//! ```text
//! scene_file ─► Scene ─► render ─► Film ─► image_file (PNG, OpenEXR)
//!                 │         ├─ path: one path of light, 31 wavelengths at once
//!                 │         └─ sums: the exact sums of a part of a picture; picture_file keeps them
//!                 ├─ objects: shapes and meshes ─ what a ray hits, and how deep a line runs through a solid
//!                 ├─ materials: diffuse, pca_snow, each even or by a texture
//!                 └─ lights, camera
//! ```
//!
//! [`Scene::load`](scene::Scene::load) reads a scene and takes the curves of its snow from a table,
//! [`render::render`] makes the picture, and [`image_file`] stores it. What a hit on snow means is told in
//! [`material::pca_snow`]. Past the door nothing fails: a scene that was read can be rendered.
//!
//! [`swatch`] draws sheets of colours with labels, and [`texture`] the grey of snow over them.
//!
//! A picture has the same bits on any number of threads. Geometry is single precision, in metres; where a sign decides
//! what is inside (the edges of triangles) arithmetic is exact, so that depths hold from every direction and through
//! every edge.
//!
//! **Simplified.** Snow takes in light at one point and gives it out at another on a straight line, with the curves of a
//! slab; light leaves it alike in all directions. Faces are flat: normals of a mesh's vertices are not used.
//!
//! **Out of scope.** Building tables (`snowblue-database`); names of files, options and progress bars (the faces).

pub mod error;

pub mod spectrum;
mod spectrum_file;

mod png_image;

pub mod bounds;
mod hierarchy;
mod lanes;
mod pencil;
pub mod ray;
mod triangle;

pub mod camera;
pub mod mending;
pub mod topology;
pub mod triangles;

pub mod cuboid;
pub mod ellipsoid;
pub mod instance;
pub mod mesh;
pub mod placement;
pub mod plane;
pub mod shape;

mod relief;

pub mod drift;
pub mod height_field;
pub mod igloo;
pub mod mesh_file;

mod body;
pub mod chord;
pub mod objects;
pub mod probe;
pub mod surface_texture;

pub mod light;
pub mod material;

mod retina;

pub mod scene;
pub mod scene_file;

pub mod sampling;

pub mod inspection;

mod direct;
mod path;
mod reference;
mod tracer;

pub mod channels;
pub mod film;
pub mod portion;
pub mod sums;

mod pixel_sums;

mod first_hit;
pub mod render;

pub mod picture;

pub mod lettering;
pub mod swatch;
pub mod texture;

pub mod image_file;
pub mod origin;
pub mod picture_file;

pub use channels::Channels;
pub use error::RenderError;
pub use film::Film;
pub use portion::Portion;
pub use render::{Progress, Rendering, render};
pub use retina::FalseColor;
pub use scene::Scene;
pub use scene_file::Overrides;
pub use sums::Sums;

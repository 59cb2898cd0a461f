//! The readers. Each says whether the file is valid.

use std::io::Write as _;

use snowblue_database::PcaSnow;
use snowblue_database::axes_file;
use snowblue_database::file::AnyTable;
use snowblue_geometry::mesh_files::read_mesh_from;
use snowblue_render::SceneFile;
use snowblue_render::files::FilesInMemory;
use snowblue_render::film::resumable_file::ResumableImage;
use snowblue_transport::layer_file::LayerFile;
use snowblue_transport::optics::IceTable;

/// What every scene needs that is no scene of the fuzzer's own.
const CAMERA: &str = "[camera]\nposition = [0, -5, 1]\nlook_at = [0, 0, 0]\n";
const LIGHT: &str = "[environment]\nradiance_w_m2_sr = 1\n";

/// The axes of a table, in TOML.
pub fn axes(bytes: &[u8]) -> bool {
    axes_file::parse(&String::from_utf8_lossy(bytes)).is_ok_and(|axes| axes.check(IceTable::default()).is_ok())
}

/// An image of the sky, in OpenEXR or Radiance.
pub fn exr_sky(bytes: &[u8]) -> bool {
    build(&format!("{CAMERA}[environment]\nimage = \"file.exr\"\n"), "file.exr", bytes)
}

/// An image with sums to resume from, in OpenEXR.
///
/// # Panics
///
/// When no temporary file can be written.
pub fn exr_sums(bytes: &[u8]) -> bool {
    let mut file = tempfile::NamedTempFile::new().expect("a temporary file can be made");
    file.write_all(bytes).expect("a temporary file can be written");
    ResumableImage::open(file.path()).and_then(|image| image.read_sums()).is_ok()
}

/// A glTF or GLB: as a mesh, and as a scene with materials, lights and a camera.
pub fn gltf(bytes: &[u8]) -> bool {
    let files = FilesInMemory::from([("file.glb", bytes)]);
    let is_mesh = read_mesh_from(&files, "file.glb", None).is_ok();
    build(&format!("gltf = \"file.glb\"\n{CAMERA}{LIGHT}"), "file.glb", bytes) && is_mesh
}

/// A map of heights. The first byte chooses the format.
pub fn heights(bytes: &[u8]) -> bool {
    let Some((first, bytes)) = bytes.split_first() else { return false };
    let name = ["file.asc", "file.tif", "file.exr", "file.png"][usize::from(*first % 4)];
    let scene = format!(
        "{CAMERA}{LIGHT}[material.snow]\ntype = \"diffuse\"\nreflectance = 0.5\n[[object]]\n\
         shape = \"heights\"\nbottom = -1e4\nfile = \"{name}\"\nfill = 0\nsize = [1, 1, 1]\nmaterial = \"snow\"\n"
    );
    build(&scene, name, bytes)
}

/// Layers of snow, in TOML.
pub fn layers(bytes: &[u8]) -> bool {
    LayerFile::parse(&String::from_utf8_lossy(bytes)).is_ok()
}

/// A table, in NetCDF.
pub fn netcdf(bytes: &[u8]) -> bool {
    let table = AnyTable::from_bytes("table.nc", bytes);
    if let Ok(AnyTable::Compressed(table)) = &table {
        let samples = [0, table.axes.samples() - 1].map(|number| table.axes.table_sample(number));
        let mut spectrum = vec![0.0; table.axes.wavelengths_nm.len()];
        for snow in samples.iter().filter_map(|sample| PcaSnow::new(table, sample).ok()) {
            snow.transmittance(1.0, 30.0, &mut spectrum);
        }
    }
    table.is_ok()
}

/// A Wavefront OBJ mesh.
pub fn obj(bytes: &[u8]) -> bool {
    mesh("file.obj", bytes)
}

/// A PLY mesh.
pub fn ply(bytes: &[u8]) -> bool {
    mesh("file.ply", bytes)
}

/// A texture, as PNG.
pub fn png(bytes: &[u8]) -> bool {
    let scene = format!(
        "{CAMERA}{LIGHT}[material.wall]\ntype = \"diffuse\"\ntexture = \"file.png\"\n[[object]]\nshape = \"box\"\n\
         size = [1, 1, 1]\nmaterial = \"wall\"\n"
    );
    build(&scene, "file.png", bytes)
}

/// A scene in TOML, without files.
pub fn scene(bytes: &[u8]) -> bool {
    build(&String::from_utf8_lossy(bytes), "file", &[])
}

/// Spectra of a light and of a surface, as CSV.
pub fn spectrum_csv(bytes: &[u8]) -> bool {
    let scene = format!(
        "{CAMERA}{LIGHT}[material.wall]\ntype = \"diffuse\"\nreflectance_spectrum = \"file.csv\"\n[[object]]\n\
         shape = \"box\"\nsize = [1, 1, 1]\nmaterial = \"wall\"\n"
    );
    let is_reflectance = build(&scene, "file.csv", bytes);
    build(&format!("{CAMERA}{LIGHT}spectrum = \"file.csv\"\n"), "file.csv", bytes) && is_reflectance
}

/// An STL mesh.
pub fn stl(bytes: &[u8]) -> bool {
    mesh("file.stl", bytes)
}

/// Reads a mesh, and makes an object of it.
fn mesh(name: &str, bytes: &[u8]) -> bool {
    let scene = format!(
        "{CAMERA}{LIGHT}[material.wall]\ntype = \"diffuse\"\nreflectance = 0.5\n[[object]]\n\
         mesh = \"{name}\"\nmaterial = \"wall\"\n"
    );
    build(&scene, name, bytes)
}

/// Reads a scene and builds it, with one file beside it.
fn build(text: &str, name: &str, bytes: &[u8]) -> bool {
    let files = FilesInMemory::from([(name, bytes)]);
    SceneFile::parse(text, "scene.toml").is_ok_and(|scene| scene.description.build(&files).is_ok())
}

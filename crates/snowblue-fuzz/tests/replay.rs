//! Replays the inputs in `fuzz/seeds` and `fuzz/regressions`, and damaged seeds: no reader may panic, or take more than
//! half a gigabyte of memory. An allocation beyond that aborts the test.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::alloc::System;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use cap::Cap;
use rand_core::{Rng as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;
use snowblue_fuzz::{READERS, Reader};

#[global_allocator]
static MEMORY: Cap<System> = Cap::new(System, 512 << 20);

/// Damaged copies of each seed: so many cut, and so many with a few other bytes.
const DAMAGED: u32 = 150;

/// The inputs of a folder for a reader, by their paths.
fn inputs(folder: &str, reader: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz").join(folder).join(reader);
    let Ok(files) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut paths: Vec<PathBuf> = files.map(|file| file.unwrap().path()).collect();
    paths.sort();
    paths.into_iter().map(|path| (path.clone(), std::fs::read(path).unwrap())).collect()
}

fn read(reader: &Reader, bytes: &[u8], name: &str) -> bool {
    let outcome = catch_unwind(AssertUnwindSafe(|| (reader.read)(bytes)));
    outcome.unwrap_or_else(|_| panic!("the reader {} panics on {name}", reader.name))
}

fn replay(name: &str) {
    let reader = READERS.iter().find(|reader| reader.name == name).unwrap();
    for (path, bytes) in inputs("regressions", name) {
        read(reader, &bytes, &path.display().to_string());
    }
    let mut random = Pcg64Mcg::seed_from_u64(1);
    let mut below = |end: usize| usize::try_from(random.next_u64() % end as u64).unwrap();
    for (path, bytes) in inputs("seeds", name) {
        let path = path.display();
        assert!(read(reader, &bytes, &path.to_string()), "{path} is wrong");
        for _ in 0..DAMAGED {
            let length = below(bytes.len());
            read(reader, &bytes[..length], &format!("the first {length} bytes of {path}"));
        }
        for _ in 0..DAMAGED {
            let mut changed = bytes.clone();
            let changes: Vec<(usize, u8)> =
                (0..=below(3)).map(|_| (below(bytes.len()), u8::try_from(below(256)).unwrap())).collect();
            changes.iter().for_each(|&(at, byte)| changed[at] = byte);
            read(reader, &changed, &format!("{path} with the bytes {changes:?}"));
        }
    }
}

#[test]
fn every_reader_has_a_target_and_a_seed() {
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/Cargo.toml");
    let targets = std::fs::read_to_string(manifest).unwrap();
    for Reader { name, .. } in READERS {
        assert!(targets.contains(&format!("path = \"fuzz_targets/{name}.rs\"")), "{name} has no target");
        assert!(!inputs("seeds", name).is_empty(), "{name} has no seed");
    }
}

#[test]
fn damaged_axes_of_tables_are_survived() {
    replay("axes");
}

#[test]
fn damaged_skies_in_exr_are_survived() {
    replay("exr_sky");
}

#[test]
fn damaged_sums_in_exr_are_survived() {
    replay("exr_sums");
}

#[test]
fn damaged_gltf_files_are_survived() {
    replay("gltf");
}

#[test]
fn damaged_heights_are_survived() {
    replay("heights");
}

#[test]
fn damaged_layers_of_snow_are_survived() {
    replay("layers");
}

#[test]
fn damaged_tables_in_netcdf_are_survived() {
    replay("netcdf");
}

#[test]
fn damaged_obj_files_are_survived() {
    replay("obj");
}

#[test]
fn damaged_ply_files_are_survived() {
    replay("ply");
}

#[test]
fn damaged_textures_in_png_are_survived() {
    replay("png");
}

#[test]
fn damaged_scenes_are_survived() {
    replay("scene");
}

#[test]
fn damaged_spectra_in_csv_are_survived() {
    replay("spectrum_csv");
}

#[test]
fn damaged_stl_files_are_survived() {
    replay("stl");
}

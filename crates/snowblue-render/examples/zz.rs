//! scratch
#![allow(clippy::all, clippy::unwrap_used, clippy::print_stdout, missing_docs)]
use snowblue_database::file::{self, AnyTable};
use snowblue_render::material::pca_snow::PathMode;
use snowblue_render::*;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let AnyTable::Compressed(table) = file::read(std::path::Path::new(&a[1])).unwrap() else { panic!() };
    let p = |k: usize| a[k].parse::<u32>().unwrap();
    let path = match a[6].as_str() {
        "normal" => PathMode::Normal,
        "view" => PathMode::View,
        "light" => PathMode::Light,
        _ => PathMode::Easiest,
    };
    let o = Overrides {
        path: Some(path),
        width: Some(p(3)),
        height: Some(p(4)),
        samples_per_pixel: Some(p(5)),
        max_bounces: Some(a.get(7).map_or(0, |b| b.parse().unwrap())),
        ..Default::default()
    };
    let t = std::time::Instant::now();
    let scene = Scene::load(std::path::Path::new(&a[2]), &table, &o).unwrap();
    let loaded = t.elapsed().as_secs_f64();
    let cpu = || {
        let s = std::fs::read_to_string("/proc/self/stat").unwrap();
        let f: Vec<&str> = s.split(' ').collect();
        f[13].parse::<f64>().unwrap() / 100.0
    };
    let c = cpu();
    let pool = std::env::var("T").map_or(1, |t| t.parse().unwrap());
    rayon::ThreadPoolBuilder::new().num_threads(pool).build_global().unwrap();
    let t = std::time::Instant::now();
    let r = render(&scene, &|_| {});
    let n = f64::from(p(3) * p(4)) * f64::from(p(5));
    println!(
        "{} load {loaded:.2} s, wall {:.2} s, {:.0} ns/sample cpu; {:?}",
        a[6],
        t.elapsed().as_secs_f64(),
        (cpu() - c) / n * 1e9,
        r.statistics
    );
    if let Some(o) = a.get(8) {
        image_file::write_png(&r.film, scene.film.exposure, &[], std::path::Path::new(o)).unwrap();
    }
}

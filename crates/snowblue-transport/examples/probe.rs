use snowblue_transport::{grain::Spheroid, rng::Stream, sample::SizeMeasure, scatter::Grain};
fn main() {
    let run = |psi: f64, alpha: f64, n: f64| {
        let shape = Spheroid::of_unit_size(psi, SizeMeasure::GreatestExtension);
        let grain = Grain { shape, roughness: alpha, relative_index: n };
        let count = 1_000_000u64;
        let t = std::time::Instant::now();
        let (mut g, mut g2, mut l, mut l2) = (0.0, 0.0, 0.0, 0.0);
        for ray in 0..count {
            let s = grain.scatter(&mut Stream::new(1, ray));
            g += s.cos_scattering; g2 += s.cos_scattering.powi(2);
            let b = s.ice_path / shape.mean_chord(); l += b; l2 += b * b;
        }
        let c = count as f64;
        let sd = |s: f64, s2: f64| ((s2 / c - (s / c).powi(2)) / c).sqrt();
        println!("psi {psi} alpha {alpha} n {n}: g {:.4}±{:.4} B {:.5}±{:.5}  n² {:.4}  {:.0} ns", g / c, sd(g, g2), l / c, sd(l, l2), n * n, t.elapsed().as_nanos() as f64 / c);
    };
    for psi in [1.0, 0.9, 0.8, 0.7, 0.6] { run(psi, 0.0, 1.31); }
    for n in [1.30, 1.32, 1.33] { run(1.0, 0.0, n); }
    for a in [0.025, 0.05, 0.1, 0.2, 0.3] { run(0.8, a, 1.311); }
    run(0.8, 0.1, 1.0);
}

//! probe
use snowblue_transport::{monte_carlo, ordinates, slab::{Slab, Incidence}, sample::SnowSample};
fn main() {
    let slab = Slab { sample: SnowSample::default(), thicknesses_cm: vec![15.0], incidences: vec![Incidence::Beam { angle_deg: 0.0 }], wavelengths_nm: vec![400.0, 500., 600., 700.] };
    let t = std::time::Instant::now();
    for r in ordinates::solve(&slab, &Default::default()).unwrap() {
        println!("{} R {:.5} ± {:.5} T {:.6} ± {:.6} A {:.6}", r.wavelength_nm, r.reflectance.value, r.reflectance.standard_error, r.transmittance.value, r.transmittance.standard_error, r.absorptance.value);
    }
    println!("{:?}", t.elapsed());
    let t = std::time::Instant::now();
    for r in monte_carlo::solve(&slab, &monte_carlo::MonteCarloOptions { rays: 200, seed: 1 }, |_, _| ()).unwrap() {
        println!("{} R {:.5} ± {:.5} T {:.6} ± {:.6} A {:.6}", r.wavelength_nm, r.reflectance.value, r.reflectance.standard_error, r.transmittance.value, r.transmittance.standard_error, r.absorptance.value);
    }
    println!("{:?}", t.elapsed());
    println!("kappa {}", slab.sample.extinction_per_m());
}

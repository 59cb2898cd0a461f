//! No self-shadowing by rounding: a ray from the surface of a convex body does not hit it, whatever its size and
//! position.

use glam::Vec3A;
use snowblue_geometry::ray::{Ray, off_surface};
use snowblue_render::scene::sampling::cosine_direction;

use crate::snow::{directions, scene};

/// A PLY file of the cube from −1 to 1.
const CUBE: &str = "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n\
    element face 6\nproperty list uchar int vertex_indices\nend_header\n\
    -1 -1 -1\n1 -1 -1\n-1 1 -1\n1 1 -1\n-1 -1 1\n1 -1 1\n-1 1 1\n1 1 1\n\
    4 0 2 3 1\n4 4 5 7 6\n4 0 1 5 4\n4 2 6 7 3\n4 0 4 6 2\n4 1 3 7 5\n";

#[test]
fn rays_from_convex_bodies_do_not_hit_them() {
    let shapes = [
        ("shape = \"box\"\nsize = [1000, 800, 500]", 1000.0),
        ("shape = \"sphere\"\nradius = 500", 1000.0),
        ("mesh = \"cube.ply\"\nscale = [500, 400, 250]", 1000.0),
        ("mesh = \"cube.ply\"\nscale = [0.5, 0.4, 0.25]", 1.0),
        ("shape = \"box\"\nsize = [0.001, 0.002, 0.003]", 0.003),
    ];
    // Around the origin, with a side through it, beside it, and far away.
    let places = [[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.0, 0.0, -0.25], [0.3, -0.2, 0.4], [20.0, 0.0, 0.01]];
    for (shape, size) in shapes {
        for (place, turn) in places.into_iter().flat_map(|place| [[0, 0, 0], [20, -35, 70]].map(|turn| (place, turn))) {
            let position = place.map(|coordinate| coordinate * size);
            let text = format!(
                "[material.grey]\ntype = \"diffuse\"\nreflectance = 0.5\n[[object]]\n{shape}\nposition = {position:?}\n\
                 rotation_deg = {turn:?}\nmaterial = \"grey\"\n[environment]\nradiance_w_m2_sr = 1\n"
            );
            let scene = scene(&text, &[("cube.ply", CUBE.into())]);
            let objects = scene.objects();
            let centre = Vec3A::from_array(position.map(|coordinate| coordinate as f32));
            let mut hits = 0;
            for (k, direction) in directions(2000).enumerate() {
                let aside = direction.any_orthonormal_vector() * (0.3 * size as f32 * (k % 17) as f32 / 17.0);
                let Some(hit) =
                    objects.first_hit(&Ray::new(centre + aside - direction * (1.5 * size as f32), direction))
                else {
                    continue;
                };
                hits += 1;
                let origin = off_surface(hit.point, hit.normal, objects.reach_m(0));
                // From near the normal to grazing.
                for (u, v) in [(0.05, 0.1), (0.5, 0.5), (0.99, 0.7), (0.9999, 0.3)] {
                    let off = Ray::new(origin, cosine_direction(hit.normal, u, v));
                    assert!(!objects.any_hit(&off, f32::INFINITY), "{shape} at {position:?} turned {turn:?}: line {k}");
                }
            }
            assert!(hits > 1000, "{shape} at {position:?}: {hits} hits");
        }
    }
}

//! `snowblue repair` on meshes as they come.

use crate::shell::{Folder, assert_names};

/// A cube as an OBJ file without one side, with a side that is turned, and with two sheets that face each other.
const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\n\
    f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 7 5\nf 1 7 3\n\
    v 2 0 0\nv 3 0 0\nv 2 1 0\nf 9 10 11\nf 9 11 10\n";

#[test]
fn holes_are_filled_and_triangles_that_bound_no_solid_are_dropped() {
    let folder = Folder::new();
    folder.write("cube.obj", CUBE);
    let words = ["12 triangles, watertight", "2 triangles dropped", "1 hole filled"];
    assert_names(&folder.stderr("repair cube.obj -o closed.ply"), &words);
    let words = ["0 triangles dropped, 0 turned, 0 holes filled"];
    assert_names(&folder.stderr("repair closed.ply -o again.obj"), &words);
    for (input, output) in [("closed.ply", "cube.stl"), ("cube.stl", "of_stl.ply")] {
        let words = ["12 triangles, watertight (0 vertices merged, 0 triangles dropped"];
        assert_names(&folder.stderr(&format!("repair {input} -o {output}")), &words);
    }
}

#[test]
fn vertices_that_lie_close_together_are_joined_on_demand() {
    let folder = Folder::new();
    // A tetrahedron whose triangles have corners of their own, up to 0.002 apart.
    let apart = "v 0 0 0\nv 0 1 0\nv 1 0 0\nv 0.001 0 0\nv 1 0.001 0\nv 0 0 1\nv 0 0 0\nv 0 0 1.001\nv 0 1.001 0\n\
        v 1 0 0\nv 0 1 0\nv 0 0.001 1\nf 1 2 3\nf 4 5 6\nf 7 8 9\nf 10 11 12\n";
    folder.write("apart.obj", apart);
    let words = ["apart.obj: ", "--merge-distance joins vertices that lie close together"];
    folder.assert_refused("repair apart.obj -o closed.ply", &words);
    let words = ["4 triangles, watertight (8 vertices merged, 0 triangles dropped, 0 turned, 0 holes filled"];
    assert_names(&folder.stderr("repair apart.obj --merge-distance 0.01 -o closed.ply"), &words);
}

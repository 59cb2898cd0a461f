//! `snowblue repair` on meshes as they come.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

mod shell;

use std::path::Path;

use shell::{assert_refused, snowblue};

/// A cube as an OBJ file without one side, with a side that is turned, and with two sheets that face each other.
const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\n\
    f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 7 5\nf 1 7 3\n\
    v 2 0 0\nv 3 0 0\nv 2 1 0\nf 9 10 11\nf 9 11 10\n";

fn words(path: &Path) -> &str {
    path.to_str().unwrap()
}

#[test]
fn holes_are_filled_and_triangles_that_bound_no_solid_are_dropped() {
    let folder = tempfile::tempdir().unwrap();
    let [input, output, again] = ["cube.obj", "closed.ply", "again.obj"].map(|name| folder.path().join(name));
    std::fs::write(&input, CUBE).unwrap();
    let repaired = snowblue(&["repair", words(&input), "-o", words(&output)]);
    let message = String::from_utf8(repaired.stderr).unwrap();
    assert!(repaired.status.success() && message.contains("12 triangles, watertight"), "{message}");
    assert!(message.contains("2 triangles dropped") && message.contains("1 hole filled"), "{message}");
    let again = snowblue(&["repair", words(&output), "-o", words(&again)]);
    let message = String::from_utf8(again.stderr).unwrap();
    assert!(message.contains("0 triangles dropped, 0 turned, 0 holes filled"), "{message}");
    let [stl, from_stl] = ["cube.stl", "of_stl.ply"].map(|name| folder.path().join(name));
    for (input, output) in [(&output, &stl), (&stl, &from_stl)] {
        let repaired = snowblue(&["repair", words(input), "-o", words(output)]);
        let message = String::from_utf8(repaired.stderr).unwrap();
        assert!(message.contains("12 triangles, watertight (0 vertices merged, 0 triangles dropped"), "{message}");
    }
}

#[test]
fn what_cannot_be_closed_or_written_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let [input, output] = ["fins.obj", "closed.ply"].map(|name| folder.path().join(name));
    // Three triangles at one edge.
    std::fs::write(&input, "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 -1 0\nf 1 2 3\nf 1 2 4\nf 1 2 5\n").unwrap();
    let open = ["fins.obj: ", "edges are still open"];
    assert_refused(&["repair", words(&input), "-o", words(&output)], &open);
    // A sheet, and nothing but sheets.
    std::fs::write(&input, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    assert_refused(&["repair", words(&input), "-o", words(&output)], &["fins.obj: nothing is inside"]);
    std::fs::write(&input, "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n").unwrap();
    assert_refused(&["repair", words(&input), "-o", words(&output)], &["fins.obj: nothing is inside"]);
    assert!(!output.exists());
    assert_refused(&["repair", words(&input), "-o", words(&folder.path().join("a.glb"))], &[".ply, .obj or .stl"]);
    assert_refused(&["repair", words(&folder.path().join("gone.ply")), "-o", words(&output)], &["gone.ply"]);
    assert_refused(&["repair", words(&input), "-o", words(&input)], &["fins.obj"]);
}

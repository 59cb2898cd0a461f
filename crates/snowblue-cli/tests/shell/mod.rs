//! Runs the command as a shell would.

#![allow(dead_code, reason = "each test file uses a part")]

use std::process::{Command, Output};

pub(crate) fn snowblue(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_snowblue")).args(arguments).output().unwrap()
}

/// What a command that must succeed prints.
pub(crate) fn stdout(arguments: &[&str]) -> String {
    let output = snowblue(arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// Runs a command that must fail on its input: exit code 2, nothing on stdout, one line on stderr.
pub(crate) fn refused(arguments: &[&str]) -> String {
    let output = snowblue(arguments);
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), output.stdout.len()), (Some(2), 0), "{arguments:?}: {message}");
    assert_eq!(message.trim_end().lines().count(), 1, "{arguments:?}: {message}");
    message
}

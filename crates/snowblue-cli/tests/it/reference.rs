//! The chapter on the command is what the command says of itself. After a change of options:
//! `UPDATE_REFERENCE=1 cargo test -p snowblue-cli --test it reference`.

use std::fmt::Write;
use std::path::Path;

use crate::shell::command;

const HEAD: &str = "\
# The command

This chapter is the output of `snowblue COMMAND --help` for each command. Values in brackets are ranges and defaults.
[First steps](start.md) shows the commands at work.
";

/// The help of a command, in 100 columns.
fn help(words: &[&str]) -> String {
    let output = command(&words.join(" ")).arg("--help").env("COLUMNS", "100").output().unwrap();
    assert!(output.status.success(), "{words:?}");
    String::from_utf8(output.stdout).unwrap()
}

/// The names of the commands that a help lists.
fn commands(help: &str) -> Vec<&str> {
    let list = help.split_once("\nCommands:\n").map_or("", |(_, rest)| rest);
    let list = list.split("\n\n").next().unwrap();
    // The lines of a description that goes on are indented more.
    let named = list.lines().filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    named.filter_map(|line| line.split_whitespace().next()).filter(|name| *name != "help").collect()
}

/// Appends the help of a command and of those below it.
fn describe(words: &[&str], page: &mut String) {
    let help = help(words);
    let title = [&["snowblue"], words].concat().join(" ");
    let level = "#".repeat((words.len() + 1).max(2));
    // Lines that clap fills with blanks.
    let text: Vec<&str> = help.trim_end().lines().map(str::trim_end).collect();
    write!(page, "\n{level} {title}\n\n```text\n{}\n```\n", text.join("\n")).unwrap();
    for name in commands(&help) {
        describe(&[words, &[name]].concat(), page);
    }
}

#[test]
fn the_chapter_on_the_command_is_its_help() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/src/command.md");
    let mut page = HEAD.to_owned();
    describe(&[], &mut page);
    if std::env::var_os("UPDATE_REFERENCE").is_some() {
        std::fs::write(&path, &page).unwrap();
    }
    let written = std::fs::read_to_string(&path).unwrap_or_default();
    let differs = page.lines().zip(written.lines()).find(|(now, then)| now != then);
    assert!(page == written, "{}: UPDATE_REFERENCE=1 writes it again; it differs at {differs:?}", path.display());
}

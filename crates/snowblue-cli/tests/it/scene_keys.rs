//! The schema of scene files is that of the program, and the chapter on the keys of scenes is what the schema says.
//! After a change of keys: `UPDATE_REFERENCE=1 cargo test -p snowblue-cli --test it scene_keys`.

use std::fmt::Write;
use std::path::Path;

use serde_json::{Map, Value};

use crate::shell::stdout;

const HEAD: &str = "\
# Keys of scene files

This chapter lists every key of a scene file with its unit and range. It is made from the JSON Schema that
`snowblue schema scene` writes; an editor that reads the schema completes these keys. [Rendering](rendering.md) explains
them. Lengths are in metres.
";

/// Writes a file, or asserts that it is up to date.
fn assert_current(path: &str, text: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path);
    if std::env::var_os("UPDATE_REFERENCE").is_some() {
        std::fs::write(&path, text).unwrap();
    }
    let written = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(text == written, "{}: UPDATE_REFERENCE=1 writes it again", path.display());
}

#[test]
fn the_schema_beside_the_scenes_is_that_of_the_program() {
    assert_current("scenes/scene.schema.json", &stdout("schema scene"));
    assert_current("scenes/layers.schema.json", &stdout("schema layers"));
}

#[test]
fn the_chapter_on_the_keys_of_scenes_is_what_the_schema_says() {
    let schema: Value = serde_json::from_str(&stdout("schema scene")).unwrap();
    let mut page = Page { definitions: &schema["definitions"], text: HEAD.to_owned() };
    page.section(2, "The file", &schema);
    for key in ["camera", "film", "integrator", "light_field", "material", "light", "environment", "sky", "object"] {
        let value = &schema["properties"][key];
        let is_list = value["type"] == "array";
        let title = match key {
            "material" => "`[material.NAME]`".to_owned(),
            _ if is_list => format!("`[[{key}]]`"),
            _ => format!("`[{key}]`"),
        };
        let inner = if is_list { &value["items"] } else { value };
        let inner = inner.get("additionalProperties").filter(|inner| inner.is_object()).unwrap_or(inner);
        page.section(2, &title, inner);
    }
    assert_current("docs/src/scene_keys.md", &page.text);
}

/// A chapter in Markdown.
struct Page<'schema> {
    definitions: &'schema Value,
    text: String,
}

impl<'schema> Page<'schema> {
    /// The schema itself, if it refers to a definition or may be null.
    fn resolved(&self, schema: &'schema Value) -> &'schema Value {
        let inner = ["anyOf", "allOf"].into_iter().find_map(|word| {
            let choices = schema[word].as_array()?.iter().filter(|choice| choice["type"] != "null");
            let choices: Vec<&Value> = choices.collect();
            if let [only] = choices[..] { Some(only) } else { None }
        });
        match (schema["$ref"].as_str(), inner) {
            (Some(name), _) => self.resolved(&self.definitions[name.trim_start_matches("#/definitions/")]),
            (None, Some(inner)) => self.resolved(inner),
            (None, None) => schema,
        }
    }

    /// A section on a table, and on the tables inside it.
    fn section(&mut self, level: usize, title: &str, schema: &'schema Value) {
        let schema = self.resolved(schema);
        write!(self.text, "\n{} {title}\n", "#".repeat(level)).unwrap();
        self.describe(level, schema);
    }

    /// The description, the keys and the kinds of a table.
    fn describe(&mut self, level: usize, schema: &'schema Value) {
        if let Some(text) = schema["description"].as_str() {
            write!(self.text, "\n{}\n", wrapped(&sentence(text))).unwrap();
        }
        if let Some(keys) = schema["properties"].as_object() {
            self.keys(schema, keys);
        }
        for kinds in ["oneOf", "anyOf"] {
            for kind in schema[kinds].as_array().into_iter().flatten() {
                let kind = self.resolved(kind);
                match name_of(kind) {
                    Some(name) => self.section(level + 1, &name, kind),
                    None => self.describe(level, kind),
                }
            }
        }
        let Some(keys) = schema["properties"].as_object() else { return };
        // The tables of the root have sections of their own.
        if level == 2 && keys.contains_key("camera") {
            return;
        }
        for (key, value) in keys {
            let inner = self.resolved(value);
            let items = self.resolved(&inner["items"]);
            let table = if inner["type"] == "array" { items } else { inner };
            if has_keys(table) && key != "between" {
                self.section(level + 1, &format!("`{key}`"), table);
            }
        }
    }

    /// The table of keys.
    fn keys(&mut self, schema: &Value, keys: &'schema Map<String, Value>) {
        let required: Vec<&str> =
            schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
        let rows: Vec<_> = keys.iter().filter(|(_, value)| value["const"].is_null()).collect();
        if rows.is_empty() {
            return;
        }
        self.text += "\n| key | meaning | values | default |\n|---|---|---|---|\n";
        for (key, value) in rows {
            let meaning = value["description"].as_str().map(sentence).unwrap_or_default();
            let default = match &value["default"] {
                Value::Null | Value::Object(_) if required.contains(&&**key) => "required".to_owned(),
                Value::Null | Value::Object(_) => String::new(),
                Value::Array(list) if list.is_empty() => String::new(),
                default => format!("`{default}`"),
            };
            let values = self.values(value).replace('|', "\\|");
            writeln!(self.text, "| `{key}` | {meaning} | {values} | {default} |").unwrap();
        }
    }

    /// What values a key takes.
    fn values(&self, schema: &'schema Value) -> String {
        let schema = self.resolved(schema);
        if let Some(word) = schema["const"].as_str() {
            return format!("`\"{word}\"`");
        }
        if let Some(words) = schema["enum"].as_array() {
            let words = words.iter().filter(|word| !word.is_null()).map(|word| format!("`{word}`"));
            return words.collect::<Vec<_>>().join(", ");
        }
        if has_keys(schema) {
            return if schema["properties"]["type"]["const"].is_null() { "a table" } else { "a table by `type`" }
                .to_owned();
        }
        for choices in ["oneOf", "anyOf"] {
            if let Some(choices) = schema[choices].as_array() {
                let choices =
                    choices.iter().filter(|choice| choice["type"] != "null").map(|choice| self.values(choice));
                return choices.collect::<Vec<_>>().join(", or ");
            }
        }
        let range = || match (&schema["minimum"], &schema["maximum"]) {
            (Value::Number(least), Value::Number(greatest)) => {
                let unit = schema["x-unit"].as_str().unwrap_or("");
                let unit = if unit == "°" { unit.to_owned() } else { format!(" {unit}") };
                let number = |number: &serde_json::Number| snowblue_base::short_number(number.as_f64().unwrap());
                format!("{}–{}{}", number(least), number(greatest), unit.trim_end())
            }
            _ => String::new(),
        };
        let kind = match &schema["type"] {
            Value::Array(kinds) => kinds.iter().find(|kind| *kind != "null").unwrap_or(&Value::Null),
            kind => kind,
        };
        match kind.as_str() {
            Some("number") if range().is_empty() => "a number".to_owned(),
            Some("number") => range(),
            Some("integer") if range().is_empty() => "a whole number".to_owned(),
            Some("integer") => format!("a whole number, {}", range()),
            Some("boolean") => "`true`, `false`".to_owned(),
            Some("string") => "a text".to_owned(),
            Some("array") => match (schema["minItems"].as_u64(), self.values(&schema["items"])) {
                (Some(count), items) if items == "a table" => format!("{count} tables"),
                (Some(count), items) if Some(count) == schema["maxItems"].as_u64() => {
                    format!("{count} numbers, {items}")
                }
                (_, items) => format!("a list of: {items}"),
            },
            Some("object") => "a table".to_owned(),
            _ => String::new(),
        }
    }
}

/// Whether a schema is of a table with keys.
fn has_keys(schema: &Value) -> bool {
    let is_table = |schema: &Value| schema["properties"].is_object();
    is_table(schema)
        || ["oneOf", "anyOf"].iter().any(|word| schema[word].as_array().is_some_and(|kinds| kinds.iter().any(is_table)))
}

/// The key and the word by which a file chooses a kind of table.
fn name_of(kind: &Value) -> Option<String> {
    ["type", "shape"].into_iter().find_map(|key| {
        let word = kind["properties"][key]["const"].as_str()?;
        Some(format!("`{key} = \"{word}\"`"))
    })
}

/// A text in lines of at most 120 columns.
fn wrapped(text: &str) -> String {
    let (mut lines, mut line) = (Vec::new(), String::new());
    for word in text.split_whitespace() {
        if line.chars().count() + word.chars().count() >= 120 {
            lines.push(std::mem::take(&mut line));
        }
        if !line.is_empty() {
            line.push(' ');
        }
        line += word;
    }
    lines.push(line);
    lines.join("\n")
}

/// A description on one line, without links into the program.
fn sentence(text: &str) -> String {
    let line = text.replace('\n', " ");
    let mut plain = String::new();
    let mut rest = &*line;
    while let Some(start) = rest.find('[') {
        let (before, link) = rest.split_at(start);
        plain += before;
        match link.split_once("](") {
            Some((words, target)) if !words.contains(' ') && target.contains(')') => {
                plain += &words[1..];
                rest = target.split_once(')').map_or("", |(_, after)| after);
            }
            _ if link.starts_with("[`") => {
                let (name, after) = link[1..].split_once(']').unwrap_or((&link[1..], ""));
                plain += name;
                rest = after;
            }
            _ => {
                plain.push('[');
                rest = &link[1..];
            }
        }
    }
    plain + rest
}

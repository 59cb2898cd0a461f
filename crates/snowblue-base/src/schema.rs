//! JSON Schemas of files.
//!
//! serde flattens tables into others and chooses between tables by a key. Editors understand only whole tables, so
//! each choice becomes a table with all of its keys and no further keys.

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde_json::{Map, Value, json};

/// The JSON Schema (draft 7) of a file with the keys of a type: their meaning, units and ranges.
#[must_use]
pub fn json_schema<T: JsonSchema>() -> Value {
    let schema = SchemaSettings::draft07().into_generator().into_root_schema_for::<T>().to_value();
    let definitions = schema["definitions"].clone();
    let mut whole = closed(&schema, &definitions);
    let mut named = Map::new();
    let mut missing = references(&whole);
    while let Some(name) = missing.pop() {
        if !named.contains_key(&name) {
            let definition = closed(&definitions[&name], &definitions);
            missing.extend(references(&definition));
            named.insert(name, definition);
        }
    }
    whole["$schema"] = schema["$schema"].clone();
    whole["definitions"] = Value::Object(named);
    whole
}

/// The keys of a table.
#[derive(Clone, Default)]
struct Keys {
    description: Option<Value>,
    properties: Map<String, Value>,
    required: Vec<Value>,
}

/// A schema with whole tables, also inside it.
fn closed(schema: &Value, definitions: &Value) -> Value {
    let tables = if schema.get("$ref").is_some() || is_reference(schema) { None } else { tables(schema, definitions) };
    let Some(tables) = tables else {
        return match schema {
            Value::Object(entries) => {
                let inner = entries.iter().filter(|(key, _)| *key != "definitions");
                inner.map(|(key, value)| (key.clone(), closed(value, definitions))).collect()
            }
            Value::Array(items) => items.iter().map(|item| closed(item, definitions)).collect(),
            other => other.clone(),
        };
    };
    let table = |Keys { description, properties, required }: Keys| {
        let properties: Map<_, _> =
            properties.iter().map(|(key, value)| (key.clone(), closed(value, definitions))).collect();
        let mut table = json!({ "type": "object", "properties": properties, "additionalProperties": false });
        if !required.is_empty() {
            table["required"] = required.into();
        }
        if let Some(text) = description.as_ref().and_then(Value::as_str) {
            // The description without the examples in Rust.
            table["description"] = text.split("\n\n```").next().unwrap_or_default().into();
        }
        table
    };
    let mut tables: Vec<Value> = tables.into_iter().map(table).collect();
    if tables.len() == 1 {
        return tables.remove(0);
    }
    let mut choice = json!({ "oneOf": tables });
    if let Some(description) = schema.get("description") {
        choice["description"] = description.clone();
    }
    choice
}

/// Whether a schema is a definition with a description of its own.
fn is_reference(schema: &Value) -> bool {
    schema.get("properties").is_none() && schema["allOf"].as_array().is_some_and(|parts| parts.len() == 1)
}

/// The tables that a schema permits; none if it permits other values too.
fn tables(schema: &Value, definitions: &Value) -> Option<Vec<Keys>> {
    if let Some(name) = schema["$ref"].as_str() {
        return tables(&definitions[name.trim_start_matches("#/definitions/")], definitions);
    }
    let own = schema["properties"].as_object();
    let parts = schema["allOf"].as_array();
    let choices: Vec<&Vec<Value>> = ["oneOf", "anyOf"].iter().filter_map(|word| schema[*word].as_array()).collect();
    if own.is_none() && parts.is_none() && choices.is_empty() {
        return None;
    }
    let mut all = vec![Keys {
        description: schema.get("description").cloned(),
        properties: own.cloned().unwrap_or_default(),
        required: schema["required"].as_array().cloned().unwrap_or_default(),
    }];
    let parts = parts.into_iter().flatten().map(|part| tables(part, definitions));
    let choices = choices.into_iter().map(|choice| {
        let tables: Option<Vec<_>> = choice.iter().map(|one| tables(one, definitions)).collect();
        tables.map(|tables| tables.concat())
    });
    for others in parts.chain(choices) {
        let others = others?;
        all = all.iter().flat_map(|keys| others.iter().map(|other| keys.with(other))).collect();
    }
    Some(all)
}

impl Keys {
    /// The keys of both tables, with the description of `other`.
    fn with(&self, other: &Self) -> Self {
        let mut all = self.clone();
        all.description = other.description.clone().or(all.description);
        all.properties.extend(other.properties.clone());
        all.required.extend(other.required.iter().filter(|key| !self.required.contains(key)).cloned());
        all
    }
}

/// The names of the definitions that a schema refers to.
fn references(schema: &Value) -> Vec<String> {
    match schema {
        Value::Object(entries) => {
            let own = entries.get("$ref").and_then(Value::as_str).map(|name| name.replace("#/definitions/", ""));
            own.into_iter().chain(entries.values().flat_map(references)).collect()
        }
        Value::Array(items) => items.iter().flat_map(references).collect(),
        _ => Vec::new(),
    }
}

//! Where in the text of a scene file values are.

use std::ops::Range;

use snowblue_base::KeyPath;
use snowblue_base::key_path::Step;
use toml::Spanned;
use toml::de::DeTable;

/// The line of a place, counted from 1.
pub(crate) fn line_of(text: &str, place: usize) -> usize {
    1 + text.as_bytes()[..place.min(text.len())].iter().filter(|&&byte| byte == b'\n').count()
}

/// The span of a value, or of the innermost table or list around it that is there.
pub(super) fn span_of(root: &Spanned<DeTable>, path: &KeyPath) -> Range<usize> {
    let mut steps = path.steps().iter();
    let Some(Step::Key(first)) = steps.next() else {
        return root.span();
    };
    let Some(mut value) = root.get_ref().get(first.as_str()) else {
        return root.span();
    };
    for step in steps {
        let inner = match step {
            Step::Key(key) => value.get_ref().as_table().and_then(|table| table.get(key.as_str())),
            Step::Index(index) => value.get_ref().as_array().and_then(|list| list.get(*index)),
        };
        let Some(inner) = inner else { break };
        value = inner;
    }
    value.span()
}

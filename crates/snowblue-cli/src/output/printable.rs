//! Text from files on a terminal.

/// Greatest number of characters of a message.
const MOST: usize = 1500;
/// Number of characters that are kept at the end of a longer message, which may say what is allowed.
const AT_END: usize = 300;

/// A message in one line that a terminal can show: control characters are escaped, and the middle of a long message
/// is left out.
pub(crate) fn printable(message: &str) -> String {
    let count = message.chars().count();
    let escaped = |part: &str| -> String {
        let quotes = ['"', '\'', '\\'];
        part.split_inclusive(quotes)
            .map(|piece| match piece.strip_suffix(quotes) {
                Some(text) => format!("{}{}", text.escape_debug(), &piece[text.len()..]),
                None => piece.escape_debug().to_string(),
            })
            .collect()
    };
    if count <= MOST {
        return escaped(message);
    }
    let start_of = |number: usize| message.char_indices().nth(number).map_or(message.len(), |(start, _)| start);
    let (start, end) = (&message[..start_of(MOST - AT_END)], &message[start_of(count - AT_END)..]);
    format!("{} … {} characters … {}", escaped(start), count - MOST, escaped(end))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_are_escaped_and_all_others_kept() {
        let message = "pack.toml:3: density is 'dense', but must lie in 10–900 kg/m³ (\"é\\x\")";
        assert_eq!(printable(message), message);
        assert_eq!(printable("a\x1b[2J\nb\r\0\u{202e}"), "a\\u{1b}[2J\\nb\\r\\0\\u{202e}");
    }

    #[test]
    fn long_messages_keep_their_beginning_and_their_end() {
        let long = printable(&format!("a.csv:1: expected a number, but found '{}', in nm", "é".repeat(1_000_000)));
        assert!(long.starts_with("a.csv:1: expected a number, but found 'é") && long.ends_with("é', in nm"));
        assert!(long.contains("é … 998547 characters … é") && long.chars().count() < 1600, "{long}");
    }
}

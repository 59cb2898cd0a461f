//! The lines of CSV files that people write: selection of the rows, and messages about other separators.

/// The lines of a text that are not blank, with their numbers from 1.
pub fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    (1..).zip(text.lines()).filter(|(_, line)| !line.trim().is_empty())
}

/// Whether a line begins with `#`, which makes it a comment where cells are numbers.
pub fn is_comment(line: &str) -> bool {
    line.trim_start().starts_with('#')
}

/// The lines of a text that are neither blank nor comments, with their numbers from 1.
pub fn rows(text: &str) -> impl Iterator<Item = (usize, &str)> {
    lines(text).filter(|(_, line)| !is_comment(line))
}

/// The cells of a row, without spaces and quotation marks around them. They are numbers and words, which hold no
/// commas.
pub fn cells(row: &str) -> impl Iterator<Item = &str> {
    row.split(',').map(|cell| {
        let cell = cell.trim();
        cell.strip_prefix('"').and_then(|cell| cell.strip_suffix('"')).unwrap_or(cell).trim()
    })
}

/// The end of a message on a row with a wrong number of cells, or with cells that are no numbers. If the row has
/// another separator or more commas, the text says how cells are separated. Otherwise it is empty.
pub fn separator_hint(row: &str, columns: usize) -> String {
    let cells = |separator: char| row.split(separator).count();
    let others = [(';', "semicolons"), ('\t', "tabs")];
    let name_of = |fits: &dyn Fn(usize) -> bool| others.into_iter().find(|(other, _)| fits(cells(*other)));
    let has_more_commas = cells(',') > columns;
    // First a separator that gives all columns, then commas, then a separator that gives some columns.
    let other = name_of(&|count| count == columns.max(2))
        .or(has_more_commas.then_some((',', "more commas")))
        .or_else(|| name_of(&|count| count > 1));
    match other {
        Some((_, other)) => {
            format!(": columns are separated by commas and decimals have a point, but this line has {other}")
        }
        None => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_and_blank_lines_are_no_rows() {
        let text = "# made by hand\n\na,b\n  # of them\n1,2 \n\t\n3,#4";
        assert_eq!(rows(text).collect::<Vec<_>>(), [(3, "a,b"), (5, "1,2 "), (7, "3,#4")]);
    }

    #[test]
    fn cells_have_no_spaces_and_quotation_marks_around_them() {
        assert_eq!(cells("\"nm\", 5 ,\" a b \",\"").collect::<Vec<_>>(), ["nm", "5", "a b", "\""]);
    }

    #[test]
    fn hints_name_what_a_line_has() {
        for (row, expected) in
            [("1;2", "semicolons"), ("1,5;2,5", "semicolons"), ("1\t2", "tabs"), ("1,5,2", "more commas")]
        {
            assert!(separator_hint(row, 2).ends_with(&format!("but this line has {expected}")), "{row}");
        }
        assert!(separator_hint("1,2", 2).is_empty() && separator_hint("1 2", 2).is_empty());
    }
}

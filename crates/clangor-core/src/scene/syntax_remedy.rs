//! Remedies for errors of TOML syntax.

/// Parts of the messages of the parser on numbers.
const NUMBER_ERRORS: [&str; 6] =
    ["mantissa", "fraction", "exponent", "leading zero", "numeric sign", "float"];

/// A remedy for the most frequent errors of TOML syntax.
pub(super) fn syntax_remedy(message: &str) -> &'static str {
    if message.contains("duplicate") {
        "keep one of the two, or write [[...]] for a list of tables"
    } else if message.contains("string") || message.contains("quote") {
        "put text between a pair of double quotes on one line"
    } else if NUMBER_ERRORS.iter().any(|part| message.contains(part)) {
        "write a number as 12, -0.5 or 1.2e-3: no zero before other digits, digits on both sides of a point"
    } else if message.contains("key with no value") || message.contains("missing value") {
        "write `key = value`"
    } else if message.contains("array") {
        "close the array with `]` and separate its elements with commas"
    } else if message.contains("table") {
        "close the table with `}`, or its header with `]`"
    } else {
        "correct the TOML here: one `key = value` a line, text in double quotes, comments after #"
    }
}

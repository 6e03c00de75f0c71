//! What to do about times that tables hold as dates, times of a clock or durations, and not as seconds.
//!
//! | what | in a text | in Parquet |
//! |---|---|---|
//! | date and time | `2024-05-01T12:00:00.25`, `12:00:00.25` | logical type timestamp, date or time |
//! | duration | `0 days 00:00:00.25` | whole numbers, of nanoseconds mostly: read as numbers |
//!
//! They are refused: a recording begins at the time 0, and which row is its first depends on the other files.

/// What to do where a time should be seconds.
pub(crate) const SECONDS: &str = "; write t as seconds from the beginning of the recording (pandas: \
                                  (d.t - d.t.min()).dt.total_seconds() for dates, \
                                  d.t.dt.total_seconds() for timedelta)";

/// The remedy for a text in the place of a number: that of times if the column holds times and the text is
/// one of a calendar or clock, otherwise nothing.
pub(crate) fn remedy(column: &str, text: &str) -> &'static str {
    if column == "t" && is_calendar_time(text) { SECONDS } else { "" }
}

/// Whether a text has a date (`2024-05-01`, `2024/05/01`) or a time of a clock (`12:00`) in it.
fn is_calendar_time(text: &str) -> bool {
    let letters: Vec<char> = text.chars().collect();
    let are_digits = |part: &[char]| part.iter().all(char::is_ascii_digit);
    let is_clock = |w: &[char]| w[2] == ':' && are_digits(&w[..2]) && are_digits(&w[3..]);
    let is_date =
        |w: &[char]| matches!(w[4], '-' | '/') && w[4] == w[7] && are_digits(&w[..4]) && are_digits(&w[5..7]);
    letters.windows(5).any(is_clock) || letters.windows(8).any(is_date)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_and_clocks_are_known() {
        for text in
            ["2024-05-01T12:00:00Z", "2024-05-01", "2024/05/01 1:02", "12:00:00.25", "0 days 00:00:01"]
        {
            assert!(is_calendar_time(text), "{text}");
            assert_eq!((remedy("t", text), remedy("position_x", text)), (SECONDS, ""), "{text}");
        }
        for text in ["", "0.25", "1e-3", "one", "-12-3", "NaN", "a:b"] {
            assert!(!is_calendar_time(text), "{text}");
        }
    }
}

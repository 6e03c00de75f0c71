//! Errors and warnings of a scene, drawn at their place in its text.

use std::io::IsTerminal;
use std::ops::Range;
use std::path::Path;

use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};
use clangor_core::scene::diagnostic::{Place, SHOWN, SceneError, SceneErrors, SceneWarning};
use serde_json::{Value, json};

use crate::printable::{is_hidden, printable};

/// The errors of a scene: the first ones drawn, and the number of all.
pub(crate) fn draw_errors(path: &Path, text: &str, errors: &SceneErrors) -> String {
    let mut out = String::new();
    for error in errors.0.iter().take(SHOWN) {
        let remedy = error.problem.remedy();
        out.push_str(&draw_error(path, text, &error.place, &error.problem.to_string(), Some(&remedy)));
        out.push_str("\n\n");
    }
    let count = errors.0.len();
    let plural = if count == 1 { "" } else { "s" };
    let path = path.display().to_string();
    out.push_str(&format!("{}: {count} error{plural}", printable(&path)));
    if count > SHOWN {
        out.push_str(&format!(", of which the first {SHOWN} are shown"));
    }
    out
}

/// The errors of a scene as a list for programs.
pub(crate) fn errors_json(errors: &SceneErrors) -> Value {
    let json = |error: &SceneError| {
        error_json(&error.place, &error.problem.to_string(), Some(&error.problem.remedy()))
    };
    errors.0.iter().map(json).collect()
}

/// An error with its place, line and column from 1; `null` where it has none.
pub(crate) fn error_json(place: &Place, problem: &str, remedy: Option<&str>) -> Value {
    let at = (place.line > 0).then_some((place.line, place.column));
    json!({
        "line": at.map(|(line, _)| line),
        "column": at.map(|(_, column)| column),
        "field": Some(&place.field).filter(|field| !field.is_empty()),
        "problem": problem,
        "remedy": remedy,
    })
}

/// One error at a place of a scene.
pub(crate) fn draw_error(
    path: &Path,
    text: &str,
    place: &Place,
    problem: &str,
    remedy: Option<&str>,
) -> String {
    draw(Level::ERROR, (path, text), place, problem, remedy)
}

/// The warnings of a scene: the first ones drawn, and the number of the others.
pub(crate) fn draw_warnings<'w>(
    path: &Path,
    text: &str,
    warnings: impl ExactSizeIterator<Item = &'w SceneWarning>,
) -> Vec<String> {
    let more = warnings.len().saturating_sub(SHOWN);
    let mut drawn: Vec<String> =
        warnings.take(SHOWN).map(|warning| draw_warning(path, text, warning)).collect();
    match more {
        0 => {}
        1 => drawn.push("warning: and 1 more warning".into()),
        _ => drawn.push(format!("warning: and {more} more warnings")),
    }
    drawn
}

fn draw_warning(path: &Path, text: &str, warning: &SceneWarning) -> String {
    draw(Level::WARNING, (path, text), &warning.place, &warning.doubt.to_string(), None)
}

fn draw(
    level: Level<'_>,
    (path, text): (&Path, &str),
    place: &Place,
    problem: &str,
    remedy: Option<&str>,
) -> String {
    let title = match place.field.as_str() {
        "" => problem.to_string(),
        field => format!("{field}: {problem}"),
    };
    let (title, remedy) = (printable(&title), remedy.map(printable));
    let renderer = if std::io::stderr().is_terminal() { Renderer::styled() } else { Renderer::plain() };
    // What comes from the command line has no place in the text.
    if place.line == 0 {
        let mut report = Group::with_title(level.primary_title(&*title));
        if let Some(remedy) = &remedy {
            report = report.element(Level::HELP.message(&**remedy));
        }
        return renderer.render(&[report]).to_string();
    }
    let path = path.display().to_string();
    let path = printable(&path);
    let (line, span) = excerpt(text, &place.span);
    let snippet = Snippet::source(&*line)
        .line_start(place.line)
        .path(&*path)
        .annotation(AnnotationKind::Primary.span(span));
    let mut report = level.primary_title(&*title).element(snippet);
    if let Some(remedy) = &remedy {
        report = report.element(Level::HELP.message(&**remedy));
    }
    renderer.render(&[report]).to_string()
}

/// Characters of a line that are shown before and after its marked part at most, and of that part.
const SHOWN_CHARACTERS: usize = 120;

/// The line in which a span begins, and the span in it. A table's span is its whole text: its first line is
/// enough to find it. Of a long line, the surroundings of the span are left, and every character that a
/// terminal would obey is replaced by one that it shows.
fn excerpt(text: &str, span: &Range<usize>) -> (String, Range<usize>) {
    let start = text.floor_char_boundary(span.start.min(text.len()));
    let end = text.floor_char_boundary(span.end.clamp(start, text.len()));
    let line_start = text[..start].rfind('\n').map_or(0, |newline| newline + 1);
    let line_end = text[start..].find('\n').map_or(text.len(), |newline| start + newline);
    let (before, marked) = (&text[line_start..start], &text[start..end.min(line_end)]);
    let after = &text[end.min(line_end)..line_end];
    let skipped = before.chars().count().saturating_sub(SHOWN_CHARACTERS);
    let mut line: String = before.chars().skip(skipped).map(visible).collect();
    if skipped > 0 {
        line.insert(0, '…');
    }
    let marked_start = line.len();
    line.extend(marked.chars().take(SHOWN_CHARACTERS).map(visible));
    let marked_end = line.len();
    line.extend(after.trim_end_matches('\r').chars().take(SHOWN_CHARACTERS).map(visible));
    (line, marked_start..marked_end)
}

/// A character that a terminal shows in place of one that it would obey.
fn visible(character: char) -> char {
    match character {
        '\t' => '\t',
        '\0'..='\x1f' => char::from_u32(0x2400 + character as u32).unwrap_or('\u{fffd}'),
        '\x7f' => '\u{2421}',
        _ if is_hidden(character) => '\u{fffd}',
        _ => character,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn excerpts_are_short_and_a_terminal_obeys_none_of_their_characters() {
        let text = format!("a = 1\nb = \"\x1b[31m\" # {}\n", "x".repeat(100_000));
        let (line, span) = excerpt(&text, &(10..16));
        assert!(line.len() < 600 && !line.contains('\x1b'), "{line}");
        assert_eq!(&line[span], "\"\u{241b}[31m");
        let long = format!("{}here{}", "é".repeat(5000), "y".repeat(5000));
        let (line, span) = excerpt(&long, &(10_000..10_004));
        assert_eq!(&line[span], "here");
        assert!(line.chars().count() < 300);
        assert_eq!(excerpt("ab", &(7..9)), ("ab".into(), 2..2));
    }
}

//! Errors and warnings of a scene, drawn at their place in its text.

use std::io::IsTerminal;
use std::path::Path;

use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};
use clangor_core::scene::diagnostic::{Place, SceneErrors, SceneWarning};

/// Every error of a scene.
pub(crate) fn draw_errors(path: &Path, text: &str, errors: &SceneErrors) -> String {
    let mut out = String::new();
    for error in &errors.0 {
        let remedy = error.problem.remedy();
        out.push_str(&draw(
            Level::ERROR,
            path,
            text,
            &error.place,
            &error.problem.to_string(),
            Some(&remedy),
        ));
        out.push_str("\n\n");
    }
    let count = errors.0.len();
    let plural = if count == 1 { "" } else { "s" };
    out.push_str(&format!("{}: {count} error{plural}", path.display()));
    out
}

/// One warning of a scene.
pub(crate) fn draw_warning(path: &Path, text: &str, warning: &SceneWarning) -> String {
    draw(Level::WARNING, path, text, &warning.place, &warning.doubt.to_string(), None)
}

fn draw(
    level: Level<'_>,
    path: &Path,
    text: &str,
    place: &Place,
    problem: &str,
    remedy: Option<&str>,
) -> String {
    let title = match place.field.as_str() {
        "" => problem.to_string(),
        field => format!("{field}: {problem}"),
    };
    let renderer = if std::io::stderr().is_terminal() { Renderer::styled() } else { Renderer::plain() };
    // What comes from the command line has no place in the text.
    if place.line == 0 {
        let mut report = Group::with_title(level.primary_title(&title));
        if let Some(remedy) = remedy {
            report = report.element(Level::HELP.message(remedy));
        }
        return renderer.render(&[report]).to_string();
    }
    let path = path.display().to_string();
    let start = place.span.start.min(text.len());
    let end = place.span.end.clamp(start, text.len());
    // A table's span is its whole text: its first line is enough to find it.
    let end = text[start..end].find('\n').map_or(end, |newline| start + newline);
    let snippet = Snippet::source(text).path(&path).annotation(AnnotationKind::Primary.span(start..end));
    let mut report = level.primary_title(&title).element(snippet);
    if let Some(remedy) = remedy {
        report = report.element(Level::HELP.message(remedy));
    }
    renderer.render(&[report]).to_string()
}

//! A table of files, each under the path by which it is asked for.

use std::collections::BTreeMap;

use twox_hash::XxHash3_128;

mod embedded {
    include!(concat!(env!("OUT_DIR"), "/files.rs"));
}

/// The command that builds the page, after which the program is to be built again.
pub const BUILD_COMMAND: &str = "npm --prefix web ci && npm --prefix web run build";

/// The files that there are.
#[derive(Clone, Debug, Default)]
pub struct Page {
    files: BTreeMap<String, PageFile>,
}

/// One file.
#[derive(Clone, Debug)]
pub struct PageFile {
    /// What is in it.
    pub contents: &'static [u8],
    /// Its media type, by its ending.
    pub content_type: &'static str,
    /// Names its contents: the same for the same bytes, in quotes as HTTP wants it.
    pub tag: String,
}

/// The page that was in `web/dist` when the program was built, if there was one.
pub fn embedded_page() -> Option<Page> {
    let page = Page::new(embedded::FILES.iter().copied());
    page.find("/").is_some().then_some(page)
}

impl Page {
    /// A page of the given names, without a leading `/`, and contents; `index.html` is also the answer to
    /// `/`.
    pub fn new(files: impl IntoIterator<Item = (&'static str, &'static [u8])>) -> Self {
        let mut table = BTreeMap::new();
        for (name, contents) in files {
            let file = PageFile {
                contents,
                content_type: content_type(name),
                tag: format!("\"{:032x}\"", XxHash3_128::oneshot(contents)),
            };
            if name == "index.html" {
                table.insert("/".into(), file.clone());
            }
            table.insert(format!("/{name}"), file);
        }
        Page { files: table }
    }

    /// The file of exactly this path. Nothing in a path is decoded, joined or shortened: it is in the table
    /// or it is not.
    pub fn find(&self, path: &str) -> Option<&PageFile> {
        self.files.get(path)
    }

    /// Paths that have an answer.
    pub fn paths(&self) -> impl Iterator<Item = &str> {
        self.files.keys().map(String::as_str)
    }
}

/// Media type of a file; what is unknown is bytes, which no browser runs or shows.
fn content_type(name: &str) -> &'static str {
    match name.rsplit('.').next().unwrap_or_default() {
        "html" => "text/html; charset=utf-8",
        "js" | "mjs" => "text/javascript; charset=utf-8",
        "css" => "text/css; charset=utf-8",
        "json" | "map" => "application/json",
        "webmanifest" => "application/manifest+json",
        "wasm" => "application/wasm",
        "toml" | "txt" | "md" => "text/plain; charset=utf-8",
        "svg" => "image/svg+xml",
        "png" => "image/png",
        "jpg" | "jpeg" => "image/jpeg",
        "webp" => "image/webp",
        "ico" => "image/x-icon",
        "woff2" => "font/woff2",
        _ => "application/octet-stream",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_found_as_they_are_spelt() {
        let page =
            Page::new([("index.html", b"<!doctype html>".as_slice()), ("a/b.wasm", b"\0asm".as_slice())]);
        assert_eq!(page.paths().collect::<Vec<_>>(), ["/", "/a/b.wasm", "/index.html"]);
        assert_eq!(page.find("/a/b.wasm").map(|f| f.content_type), Some("application/wasm"));
        for path in
            ["", "a/b.wasm", "/a", "/a/", "/A/b.wasm", "//index.html", "/./index.html", "/a/../index.html"]
        {
            assert!(page.find(path).is_none(), "{path}");
        }
    }

    #[test]
    fn equal_contents_have_equal_tags() {
        let tag = |bytes: &'static [u8]| Page::new([("x", bytes)]).find("/x").map(|f| f.tag.clone());
        assert_eq!(tag(b"one"), tag(b"one"));
        assert_ne!(tag(b"one"), tag(b"two"));
    }

    #[test]
    fn a_page_without_a_first_file_is_none() {
        assert_eq!(embedded_page().is_some(), embedded::FILES.iter().any(|(name, _)| *name == "index.html"));
    }
}

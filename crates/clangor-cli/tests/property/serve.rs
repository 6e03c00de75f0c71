//! `clangor serve`, in a program that was built with or without the page.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};

use clangor_serve::embedded_page;
use serde_json::Value;

/// Ends with the test, however that ends.
struct Ended(Child);

impl Drop for Ended {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn status_line(port: u16, host: &str, path: &str) -> String {
    let mut stream = TcpStream::connect(("127.0.0.1", port)).expect("connects");
    let request = format!("GET {path} HTTP/1.1\r\nHost: {host}:{port}\r\nConnection: close\r\n\r\n");
    stream.write_all(request.as_bytes()).expect("written");
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).expect("read");
    String::from_utf8_lossy(&answer).lines().next().unwrap_or_default().to_owned()
}

#[test]
fn the_page_is_served_or_it_is_said_how_to_build_it() {
    let folder = tempfile::tempdir().expect("a folder");
    assert!(crate::program::clangor(folder.path(), &["serve", "--help"]).contains("--port"));
    let Some(page) = embedded_page() else {
        println!(
            "skipped: the page was not there when the program was built; only that this is said is tested"
        );
        let output = crate::program::run(folder.path(), &["serve", "--port", "0"]);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1));
        assert!(said.contains("npm --prefix web ci && npm --prefix web run build"), "{said}");
        return;
    };
    let mut command = Command::new(env!("CARGO_BIN_EXE_clangor"));
    command.args(["serve", "--port", "0", "--json"]).current_dir(folder.path());
    let mut child = Ended(command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("starts"));
    let mut line = String::new();
    BufReader::new(child.0.stdout.take().expect("piped")).read_line(&mut line).expect("a line");
    let said: Value = serde_json::from_str(&line).expect("JSON");
    let port = said["port"].as_u64().and_then(|p| u16::try_from(p).ok()).expect("a port");
    assert_eq!(said["address"], format!("http://127.0.0.1:{port}/"));
    for path in page.paths() {
        assert_eq!(status_line(port, "localhost", path), "HTTP/1.1 200 OK", "{path}");
    }
    assert!(page.paths().any(|path| path.ends_with(".wasm")));
    assert!(status_line(port, "rebound.example", "/").contains(" 421 "));
    assert!(status_line(port, "localhost", "/../Cargo.toml").contains(" 404 "));

    let taken = crate::program::run(folder.path(), &["serve", "--port", &port.to_string()]);
    let reason = String::from_utf8_lossy(&taken.stderr).into_owned();
    assert!(taken.status.code() == Some(1) && reason.contains("in use"), "{reason}");

    let asked = Command::new("kill").args(["-INT", &child.0.id().to_string()]).status().expect("asks");
    assert!(asked.success());
    assert_eq!(child.0.wait().expect("ends").code(), Some(130));
}

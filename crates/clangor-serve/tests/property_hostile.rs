//! Over real sockets: whatever is asked, in whatever spelling, nothing outside the page is reached and the
//! next one is answered.

#[path = "../../clangor-core/tests/fuzzing/mod.rs"]
#[allow(dead_code)]
mod fuzzing;

use std::io::{ErrorKind, Read, Write};
use std::net::{Ipv6Addr, Shutdown, SocketAddr, TcpStream};
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use clangor_serve::server::{CONNECTIONS, HEAD_TIMEOUT};
use clangor_serve::{Page, ServeError, Server};
use fuzzing::{Target, fuzz};

const INDEX: &[u8] = b"<!doctype html><title>first</title>";
const WASM: &[u8] = b"\0asm\x01\0\0\0";

/// A server in a thread of its own, ended when dropped.
struct Running {
    port: u16,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<Result<(), ServeError>>>,
}

impl Running {
    fn start() -> Self {
        let page = Page::new([
            ("index.html", INDEX),
            ("assets/clangor.wasm", WASM),
            ("assets/page.js", b"'use strict'"),
        ]);
        let server = Server::bind(page, 0).expect("a free port");
        let (port, stop) = (server.port(), Arc::new(AtomicBool::new(false)));
        let asked = Arc::clone(&stop);
        let mut flow = move || match asked.load(Ordering::SeqCst) {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        };
        let thread = Some(std::thread::spawn(move || server.run(&mut flow)));
        Running { port, stop, thread }
    }

    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(("127.0.0.1", self.port)).expect("connects");
        stream.set_read_timeout(Some(Duration::from_secs(30))).expect("a timeout");
        stream
    }

    /// Everything that comes back for these bytes until the server ends the connection.
    fn raw(&self, request: &[u8]) -> Vec<u8> {
        let mut stream = self.connect();
        // The server may have answered and gone before all is written.
        let _ = stream.write_all(request);
        let mut answer = Vec::new();
        match stream.read_to_end(&mut answer) {
            Err(error) if error.kind() != ErrorKind::ConnectionReset => panic!("{error}"),
            _ => answer,
        }
    }

    /// Status, head and body of the answer to one request.
    fn ask(&self, line: &str, host: &str, more: &str) -> (u16, String, Vec<u8>) {
        let head = format!("{line} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n{more}\r\n");
        taken_apart(&self.raw(head.as_bytes()))
    }

    fn get(&self, path: &str) -> (u16, String, Vec<u8>) {
        self.ask(&format!("GET {path}"), &format!("127.0.0.1:{}", self.port), "")
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::SeqCst);
        let ended = self.thread.take().map(JoinHandle::join);
        assert!(matches!(ended, Some(Ok(Ok(())))) || std::thread::panicking(), "{ended:?}");
    }
}

/// Status 0 where there is no answer at all.
fn taken_apart(answer: &[u8]) -> (u16, String, Vec<u8>) {
    let Some(end) = answer.windows(4).position(|w| w == b"\r\n\r\n") else {
        return (0, String::new(), answer.to_vec());
    };
    let head = String::from_utf8_lossy(&answer[..end]).to_lowercase();
    let status = head.split(' ').nth(1).and_then(|s| s.parse().ok()).unwrap_or(0);
    (status, head, answer[end + 4..].to_vec())
}

#[test]
fn files_come_with_their_types_and_bytes() {
    let server = Running::start();
    let (status, head, body) = server.get("/");
    assert_eq!((status, body.as_slice()), (200, INDEX));
    assert!(head.contains("content-type: text/html; charset=utf-8"), "{head}");
    let (status, head, body) = server.get("/assets/clangor.wasm?v=1");
    assert_eq!((status, body.as_slice()), (200, WASM));
    assert!(head.contains("content-type: application/wasm") && head.contains("content-length: 8"), "{head}");
    let (status, head, body) = server.ask("HEAD /assets/page.js", &format!("localhost:{}", server.port), "");
    assert!(status == 200 && head.contains("content-length: 12") && body.is_empty(), "{head}");
}

#[test]
fn what_is_known_is_not_sent_again() {
    let server = Running::start();
    let (_, head, _) = server.get("/");
    let tag = head.lines().find_map(|l| l.strip_prefix("etag: ")).expect("a tag").to_owned();
    let host = format!("127.0.0.1:{}", server.port);
    for (tags, status) in [(tag.clone(), 304), (format!("\"x\", W/{tag}"), 304), ("\"x\"".into(), 200)] {
        let (seen, head, body) = server.ask("GET /", &host, &format!("If-None-Match: {tags}\r\n"));
        assert_eq!((seen, body.is_empty()), (status, status == 304), "{tags}: {head}");
    }
}

#[test]
fn everything_is_closed_to_other_sites() {
    let server = Running::start();
    let refused = server.ask("GET /", "rebound.example", "");
    for (status, head, _) in [server.get("/"), server.get("/none"), refused] {
        for expected in [
            "frame-ancestors 'none'",
            "default-src 'self'",
            "script-src 'self' 'wasm-unsafe-eval'",
            "x-frame-options: deny",
            "x-content-type-options: nosniff",
            "referrer-policy: no-referrer",
            "cross-origin-resource-policy: same-origin",
            "cache-control: no-cache",
        ] {
            assert!(head.contains(expected), "{status}: {expected} is not in {head}");
        }
        assert!(!head.contains("access-control-allow-origin") && !head.contains("'unsafe-inline'"), "{head}");
    }
}

#[test]
fn no_spelling_of_a_path_leads_out() {
    let server = Running::start();
    let spellings = [
        "/../../etc/passwd",
        "/..%2f..%2fetc/passwd",
        "/%2e%2e/%2e%2e/etc/passwd",
        "/%2E%2E%2F%2E%2E%2Fetc%2Fpasswd",
        "/..%5c..%5cetc%5cpasswd",
        "/..\\..\\etc\\passwd",
        "/%252e%252e/etc/passwd",
        "/%c0%ae%c0%ae/etc/passwd",
        "/assets/../index.html",
        "/assets/%2e%2e/index.html",
        "/./index.html",
        "//index.html",
        "//etc/passwd",
        "/etc/passwd",
        "/assets",
        "/assets/",
        "/index.html/",
        "/index.html%00.js",
        "/%69ndex.html",
        "/INDEX.HTML",
        "/index.html;x",
        "file:///etc/passwd",
        "/Cargo.toml",
        "/.git/config",
        "/proc/self/environ",
        "*",
        "?",
    ];
    for path in spellings {
        let (status, head, body) = server.get(path);
        // `?` is an empty path, which is `/` to an HTTP library.
        let allowed: &[u16] = if path == "?" { &[200, 400, 404, 421] } else { &[400, 404, 421] };
        assert!(allowed.contains(&status), "{path}: {head}");
        assert!(body.len() < 100 && !String::from_utf8_lossy(&body).contains("root:"), "{path}: {body:?}");
    }
    for byte in [0_u8, b'\n', b'\r', 0x7f, 0xff] {
        let mut request = b"GET /index.html".to_vec();
        request.push(byte);
        request.extend(
            format!("/x HTTP/1.1\r\nHost: 127.0.0.1:{}\r\nConnection: close\r\n\r\n", server.port).bytes(),
        );
        let (status, head, _) = taken_apart(&server.raw(&request));
        assert!([400, 404].contains(&status), "byte {byte}: {head}");
    }
    let (status, ..) = server.get(&format!("/{}", "a/".repeat(100_000)));
    assert!([0, 414, 431].contains(&status), "{status}");
    assert_eq!(server.get("/").0, 200);
}

#[test]
fn only_names_of_this_machine_are_answered() {
    let server = Running::start();
    let port = server.port;
    for host in ["localhost", "LocalHost", "127.0.0.1", "[::1]"] {
        assert_eq!(server.ask("GET /", &format!("{host}:{port}"), "").0, 200, "{host}");
    }
    let foreign = [
        "rebound.example".to_string(),
        format!("rebound.example:{port}"),
        format!("localhost.rebound.example:{port}"),
        format!("rebound.example@localhost:{port}"),
        format!("127.0.0.1.nip.io:{port}"),
        format!("127.0.0.2:{port}"),
        format!("0.0.0.0:{port}"),
        format!("[::]:{port}"),
        format!("2130706433:{port}"),
        format!("localhost:{}", port ^ 1),
        format!("localhost:0{port}"),
        "localhost".into(),
        "127.0.0.1".into(),
        String::new(),
        format!("localhost:{port}, localhost:{port}"),
        format!("localhost:{port}\r\nHost: rebound.example:{port}"),
        format!("localhost:{port}\r\nHost: localhost:{port}"),
    ];
    for host in foreign {
        let (status, head, body) = server.ask("GET /", &host, "");
        assert!([400, 421].contains(&status) && !body.starts_with(INDEX), "{host}: {head}");
    }
    let (status, ..) =
        server.ask(&format!("GET http://rebound.example:{port}/"), &format!("localhost:{port}"), "");
    assert_eq!(status, 421);
    let without = taken_apart(&server.raw(b"GET / HTTP/1.1\r\nConnection: close\r\n\r\n"));
    let old = taken_apart(&server.raw(b"GET / HTTP/1.0\r\n\r\n"));
    assert_eq!((without.0, old.0), (421, 421));
}

#[test]
fn nothing_can_be_sent_here() {
    let server = Running::start();
    let host = format!("127.0.0.1:{}", server.port);
    for method in ["POST", "PUT", "DELETE", "PATCH", "OPTIONS", "TRACE", "BREW"] {
        let (status, head, body) = server.ask(&format!("{method} /"), &host, "Content-Length: 0\r\n");
        assert!(
            status == 405 && head.contains("allow: get, head") && !body.starts_with(INDEX),
            "{method}: {head}"
        );
    }
    let (status, head, _) = server.ask(&format!("CONNECT {host}"), &host, "");
    assert!([400, 405].contains(&status), "{head}");
    let (status, ..) = server.ask("POST /", &host, "Content-Length: 99999999999\r\n");
    assert_eq!(status, 405);
    let upgrade =
        "Upgrade: websocket\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n";
    assert_ne!(server.ask("GET /", &host, upgrade).0, 101);
    assert_eq!(server.get("/").0, 200);
}

#[test]
fn heads_are_bounded() {
    let server = Running::start();
    let host = format!("127.0.0.1:{}", server.port);
    let long = format!("X-Long: {}\r\n", "x".repeat(1_000_000));
    let many: String = (0..20_000).map(|n| format!("X-{n}: y\r\n")).collect();
    for more in [long, many] {
        let (status, head, _) = server.ask("GET /", &host, &more);
        assert!([0, 400, 431].contains(&status), "{head}");
    }
    assert_eq!(server.get("/").0, 200);
}

#[test]
fn what_is_no_request_ends_its_connection_only() {
    let server = Running::start();
    let tls_hello = [0x16, 0x03, 0x01, 0x02, 0x00, 0x01, 0x00, 0x01, 0xfc, 0x03, 0x03];
    let noise: Vec<u8> = (0..4096_u32).map(|n| (n.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    for request in
        [&tls_hello[..], &noise, b"\r\n\r\n\r\n", b"GET\r\n\r\n", b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"]
    {
        let mut stream = server.connect();
        let _ = stream.write_all(request);
        let _ = stream.shutdown(std::net::Shutdown::Write);
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        assert!(!answer.windows(INDEX.len()).any(|w| w == INDEX), "{request:?}");
    }
    // Half a request, then nothing more for ever: gone with the connection.
    drop(server.connect().write_all(b"GET / HTTP/1.1\r\nHo"));
    assert_eq!(server.get("/").0, 200);
}

#[test]
fn those_who_say_nothing_keep_nobody_out() {
    let server = Running::start();
    let silent: Vec<TcpStream> = (0..2 * CONNECTIONS)
        .map(|n| {
            let mut stream = server.connect();
            let _ = stream.write_all(&b"GET / HTTP/1.1\r\nHost: "[..n % 23]);
            stream
        })
        .collect();
    let begun = Instant::now();
    for _ in 0..10 {
        assert_eq!(server.get("/").0, 200);
    }
    // Seen: 8 ms for ten answers.
    assert!(begun.elapsed() < Duration::from_secs(5), "{:?}", begun.elapsed());
    drop(silent);
}

#[test]
fn a_head_that_never_ends_is_cut_off() {
    let server = Running::start();
    let (mut stream, begun) = (server.connect(), Instant::now());
    let mut rest = [0; 16];
    // A byte a second, which no timeout between bytes would notice.
    stream.set_read_timeout(Some(Duration::from_secs(1))).expect("a timeout");
    while begun.elapsed() < 4 * HEAD_TIMEOUT {
        let sent = stream.write_all(b"G");
        match stream.read(&mut rest) {
            Err(error) if error.kind() == ErrorKind::WouldBlock && sent.is_ok() => {}
            _ => break,
        }
    }
    // Seen: 5.0 s.
    assert!(begun.elapsed() < 2 * HEAD_TIMEOUT, "{:?}", begun.elapsed());
}

#[test]
fn one_connection_asks_many_times() {
    let server = Running::start();
    let mut stream = server.connect();
    let one = format!("GET /assets/page.js HTTP/1.1\r\nHost: localhost:{}\r\n\r\n", server.port);
    let last = one.replace("\r\n\r\n", "\r\nConnection: close\r\n\r\n");
    stream.write_all((one.repeat(5) + &last).as_bytes()).expect("written");
    let mut answer = String::new();
    stream.read_to_string(&mut answer).expect("text");
    assert_eq!(answer.matches("'use strict'").count(), 6);
}

#[test]
fn both_loopback_addresses_and_no_other() {
    let server = Running::start();
    if std::net::TcpListener::bind((Ipv6Addr::LOCALHOST, 0)).is_ok() {
        TcpStream::connect((Ipv6Addr::LOCALHOST, server.port)).expect("::1 answers");
    }
    // The address by which others would reach this machine: asking the system for it sends nothing.
    let outward = std::net::UdpSocket::bind("0.0.0.0:0").and_then(|s| s.connect("192.0.2.1:9").map(|()| s));
    let Ok(SocketAddr::V4(own)) = outward.and_then(|s| s.local_addr()) else { return };
    if !own.ip().is_loopback() && !own.ip().is_unspecified() {
        TcpStream::connect((*own.ip(), server.port)).expect_err("nobody listens there");
    }
}

#[test]
fn a_port_in_use_is_said_to_be() {
    let server = Running::start();
    let refused = Server::bind(Page::default(), server.port).expect_err("in use");
    assert!(matches!(refused, ServeError::PortInUse(port) if port == server.port), "{refused}");
    assert!(refused.to_string().contains("--port 0"), "{refused}");
}

/// Requests of any bytes: each is answered or cut off, nothing outside the page comes back, and the next
/// one is answered.
#[test]
fn fuzz_requests() {
    let running = Running::start();
    let host = format!("Host: 127.0.0.1:{}\r\n", running.port);
    let seeds = [
        format!("GET / HTTP/1.1\r\n{host}\r\n"),
        format!("HEAD /assets/page.js HTTP/1.1\r\n{host}If-None-Match: \"a\", W/\"b\"\r\n\r\n"),
        format!("GET http://127.0.0.1:{}/?a=b HTTP/1.0\r\n{host}\r\n", running.port),
        format!("POST / HTTP/1.1\r\n{host}Transfer-Encoding: chunked\r\n\r\n3\r\nabc\r\n0\r\n\r\n"),
        format!("GET /assets/../../Cargo.toml HTTP/1.1\r\n{host}Connection: close\r\n\r\n"),
    ];
    let words = [
        "\r\n",
        "\r\n\r\n",
        "GET ",
        "HEAD ",
        "HTTP/1.1",
        "HTTP/2.0",
        "Host: ",
        "/../",
        "%2e%2e/",
        "%00",
        ":",
        "chunked",
        "Content-Length: 18446744073709551616\r\n",
        "Upgrade: h2c\r\n",
        "Expect: 100-continue\r\n",
        "\0",
        "\u{7f}",
    ];
    let seeds = seeds.map(String::into_bytes).to_vec();
    fuzz(&Target::parser("requests", "http", seeds, &words), &|_, bytes| {
        let mut stream = running.connect();
        let _ = stream.write_all(bytes);
        let _ = stream.shutdown(Shutdown::Write);
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        let text = String::from_utf8_lossy(&answer);
        assert!(!text.contains("[package]") && (answer.is_empty() || text.starts_with("HTTP/1.")), "{text}");
        text.lines().next().unwrap_or_default().to_owned()
    });
    assert_eq!(running.get("/").0, 200);
}

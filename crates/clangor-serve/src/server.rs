//! Listens on the loopback addresses and answers from a [`Page`].
//!
//! One thread serves all connections, as many as [`CONNECTIONS`]; beyond that the oldest is cut off, so that
//! those who connect and say nothing keep nobody out. A request whose head is longer than 8 kB, or takes
//! longer than [`HEAD_TIMEOUT`], ends its connection.

use std::collections::VecDeque;
use std::convert::Infallible;
use std::io;
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr, TcpListener};
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Duration;

use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use tokio::net::TcpStream;
use tokio::task::AbortHandle;
use tokio::time::MissedTickBehavior;

use crate::answer::answer;
use crate::page::Page;

/// Most connections at a time.
pub const CONNECTIONS: usize = 128;

/// Longest time that the head of a request may take.
pub const HEAD_TIMEOUT: Duration = Duration::from_secs(5);

/// Longest head of a request \[bytes\]: the least that hyper allows.
const LONGEST_HEAD: usize = 8192;

/// How often the one who runs the server is asked whether to go on.
const ASK_EVERY: Duration = Duration::from_millis(50);

/// Tries to find a port that is free on both addresses.
const TRIES: usize = 16;

/// Why the page cannot be served.
#[derive(Debug, thiserror::Error)]
pub enum ServeError {
    /// Someone else has the port.
    #[error(
        "port {0} is in use by another program; choose another with --port, or any free one with --port 0"
    )]
    PortInUse(u16),
    /// The system does not let this program have the port.
    #[error(
        "port {0} is not for ordinary programs; choose one above 1023 with --port, or any free one with \
         --port 0"
    )]
    PortForbidden(u16),
    /// Anything else that the system says.
    #[error("no page can be served on this machine: {0}")]
    System(#[from] io::Error),
}

/// Bound to its port, and not yet answering.
#[derive(Debug)]
pub struct Server {
    page: Page,
    port: u16,
    listeners: Vec<TcpListener>,
}

impl Server {
    /// Binds to a port of 127.0.0.1 and, where the machine has it, of ::1; port 0 is any free one.
    pub fn bind(page: Page, port: u16) -> Result<Self, ServeError> {
        for _ in 1..TRIES {
            match bind_both(port) {
                Err(ServeError::PortInUse(_)) if port == 0 => {}
                bound => return bound.map(|(port, listeners)| Server { page, port, listeners }),
            }
        }
        bind_both(port).map(|(port, listeners)| Server { page, port, listeners })
    }

    /// The port.
    pub fn port(&self) -> u16 {
        self.port
    }

    /// What to type into a browser.
    pub fn address(&self) -> String {
        format!("http://127.0.0.1:{}/", self.port)
    }

    /// Answers until `flow`, which is asked many times a second, breaks.
    pub fn run(self, flow: &mut dyn FnMut() -> ControlFlow<()>) -> Result<(), ServeError> {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_io().enable_time().build()?;
        let page = Arc::new(self.page);
        runtime.block_on(async move {
            for listener in self.listeners {
                listener.set_nonblocking(true)?;
                let listener = tokio::net::TcpListener::from_std(listener)?;
                tokio::spawn(accept(listener, Arc::clone(&page), self.port));
            }
            let mut asked = tokio::time::interval(ASK_EVERY);
            asked.set_missed_tick_behavior(MissedTickBehavior::Delay);
            while flow().is_continue() {
                asked.tick().await;
            }
            Ok(())
        })
    }
}

/// Listeners of the two addresses at the same port; at port 0, that which the first one gets.
fn bind_both(port: u16) -> Result<(u16, Vec<TcpListener>), ServeError> {
    let first = bind(SocketAddr::from((Ipv4Addr::LOCALHOST, port)))?;
    let port = first.local_addr()?.port();
    let mut listeners = vec![first];
    match bind(SocketAddr::from((Ipv6Addr::LOCALHOST, port))) {
        Ok(second) => listeners.push(second),
        Err(in_use @ ServeError::PortInUse(_)) => return Err(in_use),
        // A machine without IPv6.
        Err(_) => {}
    }
    Ok((port, listeners))
}

fn bind(address: SocketAddr) -> Result<TcpListener, ServeError> {
    TcpListener::bind(address).map_err(|error| match error.kind() {
        io::ErrorKind::AddrInUse => ServeError::PortInUse(address.port()),
        io::ErrorKind::PermissionDenied => ServeError::PortForbidden(address.port()),
        _ => ServeError::System(error),
    })
}

/// Takes connections for ever.
async fn accept(listener: tokio::net::TcpListener, page: Arc<Page>, port: u16) {
    let mut open: VecDeque<AbortHandle> = VecDeque::new();
    loop {
        let stream = match listener.accept().await {
            Ok((stream, _)) => stream,
            Err(_) => {
                // Out of descriptors, or the other side has gone: what is open ends in time.
                tokio::time::sleep(ASK_EVERY).await;
                continue;
            }
        };
        open.retain(|connection| !connection.is_finished());
        if open.len() >= CONNECTIONS
            && let Some(oldest) = open.pop_front()
        {
            oldest.abort();
        }
        open.push_back(tokio::spawn(converse(stream, Arc::clone(&page), port)).abort_handle());
    }
}

/// One connection to its end; that it ends in an error concerns only the one at the other side.
async fn converse(stream: TcpStream, page: Arc<Page>, port: u16) {
    let service = service_fn(|request| {
        let response = answer(&page, port, &request);
        async move { Ok::<_, Infallible>(response) }
    });
    let _ = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(HEAD_TIMEOUT)
        .max_buf_size(LONGEST_HEAD)
        .serve_connection(TokioIo::new(stream), service)
        .await;
}

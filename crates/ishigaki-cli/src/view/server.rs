//! As much of HTTP/1.1 as a page on the own machine needs: GET and HEAD of things that are in memory.

use crate::failure::{At, Failure};
use std::io::{self, Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::time::Duration;

/// A request's line and headers are at most this long.
const LONGEST_HEAD: usize = 16 << 10;
/// A browser that says nothing for so long is gone.
const PATIENCE: Duration = Duration::from_secs(10);

/// What is at a path: content and type.
pub type Found<'a> = Option<(&'a [u8], &'static str)>;

/// Listens on 127.0.0.1.
pub struct Server {
    listener: TcpListener,
    address: SocketAddr,
}

impl Server {
    /// Takes a port; 0 takes any that is free.
    pub fn bind(port: u16) -> io::Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
        let address = listener.local_addr()?;
        Ok(Self { listener, address })
    }

    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Answers with what `find` gives for a path, until the program ends.
    pub fn serve<'a>(&self, find: &(dyn Fn(&str) -> Found<'a> + Sync)) -> Result<(), Failure> {
        std::thread::scope(|scope| {
            loop {
                let (stream, _) = self.listener.accept().other_at("the server")?;
                // A browser that closes early or says nothing is no reason to stop.
                scope.spawn(move || answer(stream, find).ok());
            }
        })
    }
}

fn answer<'a>(mut stream: TcpStream, find: &dyn Fn(&str) -> Found<'a>) -> io::Result<()> {
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let head = read_head(&mut stream)?;
    let text = |text: &'static str| (text.as_bytes(), "text/plain; charset=utf-8");
    let (status, (content, mime), body) = match Request::parse(&head) {
        None => ("400 Bad Request", text("not a request\n"), true),
        Some(request) if !request.is_local() => ("403 Forbidden", text("only for this machine\n"), request.body),
        Some(request) if !request.is_read => ("405 Method Not Allowed", text("only GET and HEAD\n"), true),
        Some(request) => match find(request.path) {
            Some(found) => ("200 OK", found, request.body),
            None => ("404 Not Found", text("not here\n"), request.body),
        },
    };
    write!(
        stream,
        "HTTP/1.1 {status}\r\nContent-Type: {mime}\r\nContent-Length: {}\r\nCache-Control: no-store\r\n\
         X-Content-Type-Options: nosniff\r\nConnection: close\r\n\r\n",
        content.len()
    )?;
    if body {
        stream.write_all(content)?;
    }
    stream.flush()
}

/// Reads up to the empty line after the headers.
fn read_head(stream: &mut impl Read) -> io::Result<Vec<u8>> {
    let mut head = Vec::new();
    let mut piece = [0; 1024];
    while !head.windows(4).any(|end| end == b"\r\n\r\n") {
        let length = stream.read(&mut piece)?;
        if length == 0 || head.len() + length > LONGEST_HEAD {
            break;
        }
        head.extend_from_slice(&piece[..length]);
    }
    Ok(head)
}

#[derive(Debug, PartialEq)]
struct Request<'a> {
    /// Without the query.
    path: &'a str,
    /// As the browser calls this machine.
    host: &'a str,
    /// GET or HEAD.
    is_read: bool,
    /// Whether content is wanted, not only its length.
    body: bool,
}

impl<'a> Request<'a> {
    fn parse(head: &'a [u8]) -> Option<Self> {
        let text = std::str::from_utf8(head).ok()?;
        let (head, _) = text.split_once("\r\n\r\n")?;
        let mut lines = head.split("\r\n");
        let mut words = lines.next()?.split(' ');
        let (method, target, version) = (words.next()?, words.next()?, words.next()?);
        if words.next().is_some() || !version.starts_with("HTTP/1.") || !target.starts_with('/') {
            return None;
        }
        let header = |line: &'a str| line.split_once(':').filter(|(name, _)| name.eq_ignore_ascii_case("host"));
        let host = lines.find_map(header).map_or("", |(_, value)| value.trim());
        let path = target.split(['?', '#']).next().unwrap_or(target);
        Some(Self { path, host, is_read: matches!(method, "GET" | "HEAD"), body: method != "HEAD" })
    }

    /// A foreign page whose name was made to point here must not read what is here.
    fn is_local(&self) -> bool {
        let name = match self.host.rsplit_once(':') {
            Some((name, port)) if port.bytes().all(|b| b.is_ascii_digit()) => name,
            _ => self.host,
        };
        ["127.0.0.1", "localhost", ""].contains(&name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_are_read() {
        let request = Request::parse(b"GET /a/b.js?v=1 HTTP/1.1\r\nhost: localhost:80\r\n\r\n").unwrap();
        assert_eq!(request, Request { path: "/a/b.js", host: "localhost:80", is_read: true, body: true });
        assert!(request.is_local());
        let head = Request::parse(b"HEAD / HTTP/1.0\r\n\r\n").unwrap();
        assert!(head.is_read && !head.body && head.is_local());
        assert!(!Request::parse(b"POST / HTTP/1.1\r\n\r\n").unwrap().is_read);
        assert!(!Request::parse(b"GET / HTTP/1.1\r\nHost: evil.example:8080\r\n\r\n").unwrap().is_local());
        for bad in ["", "GET /\r\n\r\n", "GET http://x/ HTTP/1.1\r\n\r\n", "GET / FTP\r\n\r\n", "GET / HTTP/1.1\r\n"] {
            assert_eq!(Request::parse(bad.as_bytes()), None, "{bad:?}");
        }
        assert_eq!(Request::parse(b"GET /\xff HTTP/1.1\r\n\r\n"), None);
    }
}

//! `ishigaki view`: shows a recording, or the live page, in a browser.

mod server;

use crate::failure::{At, Failure};
use crate::{output, page, recordings};
use clap::Args;
use server::Server;
use std::path::PathBuf;
use std::process::{Command, Stdio};

#[derive(Args)]
pub struct View {
    /// A recording made by `ishigaki run SCENE --record`; without one, the live page is shown.
    #[arg(value_name = "FILE.ishi")]
    recording: Option<PathBuf>,
    /// Port on 127.0.0.1; 0 takes any that is free.
    #[arg(long, value_name = "N", default_value = "0")]
    port: u16,
    /// Only print the address, open no browser.
    #[arg(long)]
    no_open: bool,
}

impl View {
    pub fn execute(&self) -> Result<(), Failure> {
        let recording = match &self.recording {
            Some(path) => {
                let bytes = recordings::read(path)?;
                recordings::parse(&bytes, path)?;
                Some(bytes)
            }
            None => None,
        };
        let start = if recording.is_some() { page::REPLAY } else { page::LIVE };
        let start = page::file_or_advice(start)?;
        let server = Server::bind(self.port).input_at(format!("--port {}", self.port))?;
        let address = format!("http://{}/", server.address());
        output::print(&address)?;
        eprintln!("serving; Ctrl-C ends");
        if !self.no_open {
            open_browser(&address);
        }
        server.serve(&|path| match path {
            "/" => Some((start, page::mime("html"))),
            "/recording.ishi" => recording.as_deref().map(|bytes| (bytes, page::mime("ishi"))),
            path => {
                let name = path.strip_prefix('/')?;
                page::file(name).map(|content| (content, page::mime(name)))
            }
        })
    }
}

/// Opens a browser where there is a display. The address has been printed: failing is no harm.
fn open_browser(address: &str) {
    let (program, arguments): (&str, &[&str]) = if cfg!(target_os = "macos") {
        ("open", &[])
    } else if cfg!(windows) {
        ("rundll32", &["url.dll,FileProtocolHandler"])
    } else if std::env::var_os("DISPLAY").or_else(|| std::env::var_os("WAYLAND_DISPLAY")).is_some() {
        ("xdg-open", &[])
    } else {
        return;
    };
    let mut command = Command::new(program);
    command.args(arguments).arg(address).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    let _ = command.spawn();
}

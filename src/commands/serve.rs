//! `romrun --serve`.

use std::io::ErrorKind;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, UdpSocket};
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use rom_runtime::Model;
use serde_json::json;

use crate::failure::Failure;
use crate::serve::latency::Latency;
use crate::serve::{Options, Server, packet};
use crate::{interrupt, terminal};

/// How long a stop may go unnoticed where no packets come.
const PATIENCE: Duration = Duration::from_millis(100);

/// Parses `udp:PORT`, on this machine only, or `udp:ADDRESS:PORT`.
///
/// # Errors
/// What was found and what is accepted.
pub(super) fn address(text: &str) -> Result<SocketAddr, String> {
    let refuse = || {
        format!(
            "expected udp:PORT (this machine only) or udp:ADDRESS:PORT, as in udp:5005 or udp:0.0.0.0:5005, found {text:?}"
        )
    };
    let place = text.strip_prefix("udp:").ok_or_else(refuse)?;
    if let Ok(port) = place.parse() {
        return Ok(SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), port));
    }
    place.parse().map_err(|_| refuse())
}

/// Serves until it is stopped.
pub(super) fn run(
    file: &Path,
    model: &Arc<Model>,
    options: Options,
    address: SocketAddr,
    (quiet, json): (bool, bool),
) -> Result<(), Failure> {
    let help = "see `romrun --help` for what can be set";
    let mut server = Server::new(model, options).map_err(|message| Failure::input(message, help))?;
    let socket = UdpSocket::bind(address)
        .and_then(|socket| socket.set_read_timeout(Some(PATIENCE)).map(|()| socket))
        .map_err(|e| {
            Failure::input(format!("udp:{address}: {e}"), "give another port or address to --serve")
        })?;
    let address = socket.local_addr()?;
    interrupt::listen_to_termination()?;
    if !quiet {
        terminal::say(&format!(
            "serving {} on udp:{address}, {} numbers in a reply; Ctrl-C ends it\n",
            file.display(),
            server.outputs()
        ))?;
    }
    let latency = listen(&socket, &mut server)?;
    summarise(&server, &latency, quiet, json)
}

fn listen(socket: &UdpSocket, server: &mut Server) -> Result<Latency, Failure> {
    // One more than a datagram can have.
    let mut buffer = vec![0; packet::LARGEST + 1];
    let mut latency = Latency::default();
    while !interrupt::requested() {
        let (length, peer) = match socket.recv_from(&mut buffer) {
            Ok(received) => received,
            // Nothing came, a signal did, or a host is gone that was sent something.
            Err(e)
                if matches!(
                    e.kind(),
                    ErrorKind::WouldBlock
                        | ErrorKind::TimedOut
                        | ErrorKind::Interrupted
                        | ErrorKind::ConnectionReset
                        | ErrorKind::ConnectionRefused
                ) =>
            {
                continue;
            }
            Err(e) => return Err(Failure::other(format!("receiving failed: {e}"))),
        };
        let start = Instant::now();
        if let Some(reply) = server.answer(&buffer[..length], peer) {
            // A host that cannot be reached asks again.
            let _ = socket.send_to(reply, peer);
            latency.add(start.elapsed());
        }
    }
    Ok(latency)
}

fn summarise(server: &Server, latency: &Latency, quiet: bool, json: bool) -> Result<(), Failure> {
    let counts = &server.counts;
    let [median, most_of_all] = [0.5, 0.999].map(|share| latency.quantile(share));
    if json {
        terminal::say_json(&json!({
            "packets": counts,
            "ignored": counts.ignored(),
            "reply_us": { "median": median, "p99.9": most_of_all, "longest": latency.longest() },
        }))?;
    } else if !quiet {
        let mut text = format!(
            "\n{} packets, {} answered ({} of them refused), {} repeated, {} ignored; {} steps\n",
            counts.received,
            counts.answered,
            counts.refused,
            counts.repeated,
            counts.ignored(),
            counts.steps
        );
        let reasons = [
            ("wrong length", counts.wrong_length),
            ("another protocol", counts.wrong_magic),
            ("another version", counts.wrong_version),
            ("wrong checksum", counts.wrong_checksum),
            ("no request", counts.wrong_kind),
            ("not of the session", counts.strangers),
            ("old", counts.stale),
        ];
        for (reason, count) in reasons.iter().filter(|(_, count)| *count > 0) {
            text += &format!("  ignored, {reason}: {count}\n");
        }
        if let (Some(median), Some(high), Some(longest)) = (median, most_of_all, latency.longest()) {
            text += &format!(
                "  from packet to reply: median {median:.1} us, 99.9 % within {high:.1} us, longest {longest:.1} us\n"
            );
        }
        terminal::say(&text)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_an_address_only_this_machine_is_served() {
        assert!(address("udp:5005").unwrap().ip().is_loopback());
        assert_eq!(address("udp:0.0.0.0:5005").unwrap().to_string(), "0.0.0.0:5005");
        assert_eq!(address("udp:[::1]:80").unwrap().to_string(), "[::1]:80");
        for text in ["5005", "tcp:5005", "udp:", "udp:99999", "udp:host:5005", "udp:1.2.3.4"] {
            assert!(address(text).is_err(), "{text}");
        }
    }
}

//! The names of the server: for which hosts, and from which origins, a request is answered.
//!
//! In: the names and origins that were given, a request, the address to which its client has connected.
//! Out: nothing, or the refusal of the request.
//! Invariants: a request for a host that is neither this machine's own name nor a given one is refused, and so is one
//! from the page of another origin. So the page of another site reads nothing here, also not by a name of its own that
//! it lets DNS lead here. A refusal names the option that would allow the request.
//! Must not know: paths, what is answered.

use std::net::{IpAddr, SocketAddr};

use super::http::{Refusal, Request};

/// Hosts and origins that were given, besides the server's own.
#[derive(Debug)]
pub struct Names {
    /// In lower case, as they stand in a request.
    hosts: Vec<String>,
    /// In lower case, without the port that is the scheme's default.
    origins: Vec<String>,
}

impl Names {
    /// Answers to host names, and to pages of origins, at which proxies may show this server. The host of an origin is
    /// a host name too.
    pub fn new(hosts: &[String], origins: &[String]) -> Self {
        let in_lower_case = |words: &[String]| words.iter().map(|word| word.to_ascii_lowercase()).collect::<Vec<_>>();
        let origins: Vec<String> =
            in_lower_case(origins).iter().map(|origin| without_default_port(origin).to_owned()).collect();
        let hosts_of_origins = origins.iter().map(|origin| host_and_port(origin).to_owned());
        Self { hosts: in_lower_case(hosts).into_iter().chain(hosts_of_origins).collect(), origins }
    }

    /// Refuses a request for another host, and a request from the page of another origin.
    ///
    /// # Errors
    /// [`Refusal`].
    pub fn check(&self, request: &Request, local: SocketAddr, needs_origin: bool) -> Result<(), Refusal> {
        let host = request.header("host").ok_or_else(|| Refusal::new(400, "a request needs one Host field"))?;
        let host = host.to_ascii_lowercase();
        if !self.is_host(&host, local) {
            let text = format!(
                "this server is not {host:?}: use its address, or start it with this name as --view-host, or behind a \
                 proxy with the proxy's address as --view-origin"
            );
            return Err(Refusal::new(421, text));
        }
        match request.header("origin") {
            Some(origin) if self.is_origin(&origin.to_ascii_lowercase(), &host) => Ok(()),
            Some(origin) => {
                let text = format!(
                    "only the page of this server may request that, and its Origin is not {origin:?}: if a proxy shows \
                     the page there, start the server with this origin as --view-origin"
                );
                Err(Refusal::new(403, text))
            }
            None if request.has("origin") => Err(Refusal::new(403, "a request has one Origin, and not two")),
            None if needs_origin => {
                Err(Refusal::new(403, "only the page of this server may request that: Origin is missing"))
            }
            None => Ok(()),
        }
    }

    /// Whether a host is one of this server's, for a client that has connected to a local address.
    fn is_host(&self, host: &str, local: SocketAddr) -> bool {
        let (ip, port) = (local.ip().to_canonical(), local.port());
        let own = ["localhost".to_owned(), "127.0.0.1".to_owned(), "[::1]".to_owned(), host_of(ip)];
        let is = |name: &str| {
            let without = host.strip_prefix(name);
            without
                .is_some_and(|rest| rest.strip_prefix(':') == Some(&port.to_string()) || rest.is_empty() && port == 80)
        };
        // A given name may be that of a proxy, which has another port, and may send the default one or none.
        let is_proxy = |name: &str| [name, &format!("{name}:443"), &format!("{name}:80")].contains(&host);
        own.iter().any(|name| is(name)) || self.hosts.iter().any(|name| is(name) || is_proxy(name))
    }

    /// Whether an origin is that of the requested host, or a given one.
    fn is_origin(&self, origin: &str, host: &str) -> bool {
        let is_own = ["http", "https"].iter().any(|scheme| {
            let own = format!("{scheme}://{host}");
            origin == own || origin == without_default_port(&own)
        });
        is_own || self.origins.iter().any(|given| given == origin)
    }
}

/// An origin as browsers send it.
fn without_default_port(origin: &str) -> &str {
    let port = if origin.starts_with("https:") { ":443" } else { ":80" };
    origin.strip_suffix(port).unwrap_or(origin)
}

/// What an origin has after its scheme.
fn host_and_port(origin: &str) -> &str {
    origin.split_once("://").map_or(origin, |(_, host)| host)
}

/// An address as it is written in a host.
fn host_of(ip: IpAddr) -> String {
    match ip {
        IpAddr::V4(ip) => ip.to_string(),
        IpAddr::V6(ip) => format!("[{ip}]"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The status of the refusal of a request with these fields; 0 if it is answered.
    fn status(names: &Names, host: &str, origin: &str) -> u16 {
        let origin = if origin.is_empty() { String::new() } else { format!("Origin: {origin}\r\n") };
        let head = format!("GET /ws HTTP/1.1\r\nHost: {host}\r\n{origin}\r\n");
        let (request, _) = Request::parse(head.as_bytes()).unwrap().unwrap();
        let refusal = names.check(&request, "127.0.0.1:8080".parse().unwrap(), false).err();
        refusal.map_or(0, |refusal| refusal.status())
    }

    #[test]
    fn a_given_origin_is_also_a_host() {
        let names = Names::new(&[], &["https://Example.org".to_owned()]);
        for (host, origin, expected) in [
            // A proxy that keeps the host, one that adds its port, one that puts the address here.
            ("example.org", "https://example.org", 0),
            ("Example.org:443", "https://example.org", 0),
            ("127.0.0.1:8080", "https://example.org", 0),
            ("example.org", "", 0),
            ("example.org:8080", "", 0),
            ("example.org:4443", "", 421),
            ("evil.example.org", "", 421),
            ("example.org.evil", "", 421),
            ("127.0.0.1:8080", "https://example.org:4443", 403),
            ("127.0.0.1:8080", "http://example.org", 403),
            ("127.0.0.1:8080", "https://evil.example.org", 403),
            ("127.0.0.1:8080", "null", 403),
            ("evil", "https://example.org", 421),
        ] {
            assert_eq!(status(&names, host, origin), expected, "{host} {origin}");
        }
    }

    #[test]
    fn origins_have_ports_and_hosts_have_them_too() {
        let names = Names::new(&["lab".to_owned()], &["https://a:443".to_owned(), "http://[::2]:81".to_owned()]);
        for (host, origin, expected) in [
            ("a", "https://a", 0),
            ("[::2]:81", "http://[::2]:81", 0),
            ("127.0.0.1:8080", "http://[::2]:81", 0),
            ("127.0.0.1:8080", "http://[::2]", 403),
            ("lab:443", "https://lab", 0),
            ("lab:443", "http://lab:443", 0),
            ("lab:80", "http://lab", 0),
            ("lab", "https://lab", 0),
            ("lab", "https://lab:81", 403),
            ("lab:81", "", 421),
        ] {
            assert_eq!(status(&names, host, origin), expected, "{host} {origin}");
        }
    }
}

//! A connection with delay, jitter and loss: a UDP socket on loopback that holds packets back before it sends them, or drops them.

use crate::clock::Clock;
use ggrs::{Message, NonBlockingSocket};
use std::cell::Cell;
use std::io;
use std::net::{Ipv4Addr, SocketAddr, UdpSocket};
use std::rc::Rc;
use std::time::Duration;

/// How bad the connection is, one way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conditions {
    /// Time that every packet takes.
    pub delay: Duration,
    /// The most that a packet takes longer than that. Packets overtake each other.
    pub jitter: Duration,
    /// Share of packets that are lost, 0 to 1.
    pub loss: f32,
}

/// 100 ms of delay, 20 ms of jitter, 5 % of loss.
impl Default for Conditions {
    fn default() -> Self {
        Self {
            delay: Duration::from_millis(100),
            jitter: Duration::from_millis(20),
            loss: 0.05,
        }
    }
}

/// What went over a link so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Packets that were to be sent.
    pub packets: usize,
    /// Packets that were lost.
    pub lost: usize,
    /// Packets that are still held back.
    pub under_way: usize,
    /// Size of all packets without the headers of UDP, bytes.
    pub bytes: usize,
}

/// A packet that is held back.
struct Packet {
    due: Duration,
    bytes: Vec<u8>,
    to: SocketAddr,
}

/// The sending end of a bad connection, and the receiving end of the other's.
pub struct BadLink {
    socket: UdpSocket,
    clock: Clock,
    conditions: Conditions,
    seed: u64,
    held: Vec<Packet>,
    /// The session owns the link, so others read its counters here.
    traffic: Rc<Cell<Traffic>>,
}

/// Size of the longest packet, bytes. Those of two players are some fifty bytes long.
const LONGEST: usize = 4096;

impl BadLink {
    /// A link at a free port of loopback. The seed decides which packets are lost, and how long the others take, once the game has begun.
    /// Before that it is a good connection.
    ///
    /// # Errors
    /// If the system gives no socket.
    pub fn open(clock: Clock, conditions: Conditions, seed: u64) -> io::Result<Self> {
        let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0))?;
        socket.set_nonblocking(true)?;
        Ok(Self {
            socket,
            clock,
            conditions,
            seed,
            held: Vec::new(),
            traffic: Rc::default(),
        })
    }

    /// Where the link receives.
    ///
    /// # Errors
    /// If the system does not tell.
    pub fn address(&self) -> io::Result<SocketAddr> {
        self.socket.local_addr()
    }

    /// The counters of what is sent.
    pub fn traffic(&self) -> Rc<Cell<Traffic>> {
        self.traffic.clone()
    }

    fn count(&self, change: impl FnOnce(&mut Traffic)) {
        let mut traffic = self.traffic.get();
        change(&mut traffic);
        self.traffic.set(traffic);
    }

    /// How much longer than [`delay`](Conditions::delay) a packet takes that is sent now; `None` if it is lost.
    ///
    /// It depends on the seed and the time since the game began, and on nothing else. `ggrs` sends more packets on a slow computer, since
    /// some of its timers show real time. They must not change what becomes of the others.
    fn late(&self) -> Option<Duration> {
        let Some(played) = self.clock.played() else {
            return Some(Duration::ZERO);
        };
        let seed = self.seed.wrapping_add(played.as_nanos() as u64);
        let mut rng = fastrand::Rng::with_seed(seed);
        let is_lost = rng.f32() < self.conditions.loss;
        let late = self.conditions.jitter.mul_f32(rng.f32());
        (!is_lost).then_some(late)
    }

    /// Sends the packets whose time has come.
    fn send_due(&mut self) {
        let now = self.clock.now();
        let due = self.held.extract_if(.., |packet| packet.due <= now);
        let mut due: Vec<Packet> = due.collect();
        due.sort_by_key(|packet| packet.due);
        for packet in due {
            // A packet that the system does not take is one more that is lost: `ggrs` sends inputs until they are confirmed.
            let is_sent = self.socket.send_to(&packet.bytes, packet.to).is_ok();
            self.count(|traffic| {
                traffic.under_way -= 1;
                traffic.lost += usize::from(!is_sent);
            });
        }
    }
}

impl NonBlockingSocket<SocketAddr> for BadLink {
    fn send_to(&mut self, message: &Message, to: &SocketAddr) {
        let bytes = bincode::serialize(message).expect("messages can be written");
        let late = self.late();
        let is_lost = late.is_none();
        self.count(|traffic| {
            traffic.packets += 1;
            traffic.bytes += bytes.len();
            traffic.lost += usize::from(is_lost);
            traffic.under_way += usize::from(!is_lost);
        });
        if let Some(late) = late {
            let due = self.clock.now() + self.conditions.delay + late;
            let to = *to;
            self.held.push(Packet { due, bytes, to });
        }
    }

    fn receive_all_messages(&mut self) -> Vec<(SocketAddr, Message)> {
        self.send_due();
        let mut received = Vec::new();
        let mut buffer = [0; LONGEST];
        // Until nothing is left; any other error is one of a packet that is lost.
        while let Ok((length, from)) = self.socket.recv_from(&mut buffer) {
            if let Ok(message) = bincode::deserialize(&buffer[..length]) {
                received.push((from, message));
            }
        }
        received
    }
}

//! One cell of the matrix of docs/clients.md, in Rust with the crate rustdds, which shares no code with Cyclone DDS: reads
//! robot/state for a second and a plan, gives the planner a circle, and says what came.
//!
//!     client DOMAIN [KEYS]     KEYS: on a secure bus, the folder of its keys, by the names that ROS 2 has for them
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use rustdds::policy::{Durability, History, Reliability};
use rustdds::with_key::Sample;
use rustdds::{DomainParticipantBuilder, DomainParticipantSecurityConfigFiles, Keyed, QosPolicies, QosPolicyBuilder, TopicKind};
use serde::{Deserialize, Serialize};
use serde_big_array::BigArray;

// the structs of idl/c3rt.idl that are used here, field by field

#[derive(Serialize, Deserialize, Clone, Default)]
struct Header {
    session_id: u64,
    seq: u64,
    time_ns: i64,
}

#[derive(Serialize, Deserialize, Clone)]
struct RobotState {
    robot: i32,
    header: Header,
    q_rad: [f64; 7],
    dq_rad_per_s: [f64; 7],
    tau_nm: [f64; 7],
    p_we_m: [f64; 3],
    q_we: [f64; 4],
    mode: u32,
    errors: u64,
    command_success_rate: f64,
    command_seq: u64,
    command_state_ns: i64,
}

#[derive(Serialize, Deserialize, Clone)]
struct Knot {
    time_ns: i64,
    p_we_m: [f64; 3],
    v_we_m_per_s: [f64; 3],
    q_we: [f64; 4],
    force_e_n: [f64; 3],
}

#[derive(Serialize, Deserialize, Clone)]
struct Plan {
    robot: i32,
    header: Header,
    origin: [i64; 4],
    valid_until_ns: i64,
    status: u32,
    phase: String,
    solve_time_s: f64,
    knot_count: i32,
    knots: [Knot; 16],
}

#[derive(Serialize, Deserialize, Clone)]
struct TargetParameter {
    name: String,
    word: String,
    value_count: i32,
    #[serde(with = "BigArray")]
    values: [f64; 64],
}

#[derive(Serialize, Deserialize, Clone)]
struct TaskTarget {
    header: Header,
    request_id: u64,
    kind: String,
    parameter_count: i32,
    parameters: [TargetParameter; 16],
}

#[derive(Serialize, Deserialize, Clone)]
struct ServiceReply {
    request_id: u64,
    header: Header,
    process: u32,
    ok: bool,
    text: String,
}

impl Keyed for RobotState {
    type K = i32;
    fn key(&self) -> i32 {
        self.robot
    }
}
impl Keyed for Plan {
    type K = i32;
    fn key(&self) -> i32 {
        self.robot
    }
}
impl Keyed for ServiceReply {
    type K = u64;
    fn key(&self) -> u64 {
        self.request_id
    }
}

fn qos(reliable: bool, durable: bool) -> QosPolicies {
    QosPolicyBuilder::new()
        .reliability(if reliable {
            Reliability::Reliable { max_blocking_time: rustdds::Duration::from_millis(100) }
        } else {
            Reliability::BestEffort
        })
        .durability(if durable { Durability::TransientLocal } else { Durability::Volatile })
        .history(History::KeepLast { depth: 100 })
        .build()
}

fn parameter(name: &str, given: &[f64]) -> TargetParameter {
    let mut values = [0.0; 64];
    values[..given.len()].copy_from_slice(given);
    TargetParameter { name: name.to_string(), word: String::new(), value_count: given.len() as i32, values }
}

fn main() {
    let domain = std::env::args().nth(1).and_then(|word| word.parse().ok()).unwrap_or(0);
    let mut builder = DomainParticipantBuilder::new(domain);
    if let Some(folder) = std::env::args().nth(2) {
        builder = builder.builtin_security(DomainParticipantSecurityConfigFiles::with_ros_default_names(folder, String::new()));
    }
    let participant = builder.build().expect("a participant");
    let subscriber = participant.create_subscriber(&qos(false, false)).expect("a subscriber");
    let publisher = participant.create_publisher(&qos(true, true)).expect("a publisher");
    let topic = |name: &str, kind: &str, with_key, of: &QosPolicies| {
        participant.create_topic(name.to_string(), format!("c3rt::v2::{kind}"), of, with_key).expect("a topic")
    };
    let (best, reliable, event) = (qos(false, false), qos(true, false), qos(true, true));
    let mut states = subscriber
        .create_datareader_cdr::<RobotState>(&topic("robot/state", "RobotState", TopicKind::WithKey, &best), Some(best.clone()))
        .expect("a reader");
    let mut plans = subscriber
        .create_datareader_cdr::<Plan>(&topic("plan", "Plan", TopicKind::WithKey, &reliable), Some(reliable.clone()))
        .expect("a reader");
    let mut replies = subscriber
        .create_datareader_cdr::<ServiceReply>(&topic("service/reply", "ServiceReply", TopicKind::WithKey, &reliable), Some(reliable.clone()))
        .expect("a reader");
    let targets = publisher
        .create_datawriter_no_key_cdr::<TaskTarget>(&topic("task/target", "TaskTarget", TopicKind::NoKey, &event), Some(event.clone()))
        .expect("a writer");

    let (mut count, mut first, mut last, mut phase) = (0u64, 0u64, 0u64, String::new());
    let until = Instant::now() + Duration::from_secs(15);
    while Instant::now() < until && !(count >= 1000 && !phase.is_empty()) {
        while let Ok(Some(sample)) = states.take_next_sample() {
            if let Sample::Value(state) = sample.value() {
                if count == 0 {
                    first = state.header.seq;
                }
                count += 1;
                last = state.header.seq;
            }
        }
        while let Ok(Some(sample)) = plans.take_next_sample() {
            if let Sample::Value(plan) = sample.value() {
                phase = plan.phase.clone();
            }
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    let request = SystemTime::now().duration_since(UNIX_EPOCH).expect("a time").as_nanos() as u64;
    let mut parameters = vec![parameter("center_m", &[0.55, 0.0]), parameter("radius_m", &[0.08]), parameter("lead_rad", &[0.349])];
    parameters.resize(16, parameter("", &[]));
    let target = TaskTarget {
        header: Header { session_id: 0, seq: 1, time_ns: 0 },
        request_id: request,
        kind: "circle".to_string(),
        parameter_count: 3,
        parameters: parameters.try_into().ok().expect("16 parameters"),
    };
    if targets.write(target, None).is_err() {
        eprintln!("the target is not sent");
    }
    let came = format!("{count} states of {}, plan \"{phase}\"", if count == 0 { 0 } else { last - first + 1 });
    let until = Instant::now() + Duration::from_secs(10);
    while Instant::now() < until {
        while let Ok(Some(sample)) = replies.take_next_sample() {
            if let Sample::Value(reply) = sample.value() {
                if reply.request_id == request {
                    println!("{came}, {}: {}", if reply.ok { "ok" } else { "refused" }, reply.text);
                    std::process::exit(if count >= 100 && !phase.is_empty() && reply.ok { 0 } else { 1 });
                }
            }
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    eprintln!("{came}, no reply");
    std::process::exit(1);
}

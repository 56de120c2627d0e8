//! One contender of `scripts/bench`: does single pieces of work on request and says how long each took.
//!
//! Requests and answers are JSON, one object a line, on stdin and stdout. The script starts one process
//! for each contender and asks them in turn, so that whatever slows the machine down slows all of them.
//! Reading the volume, and giving memory back, are outside of every time.
//!
//! The first argument names who works: `isokit`, `fast-surface-nets` or `isosurface`.

mod memory;
mod ours;
mod peers;
mod protocol;

use protocol::{Answer, Load, Request};
use std::io::{BufRead, Write, stdin, stdout};

/// What has a volume in memory and works on it.
trait Contender {
    fn answer(&mut self, request: Request) -> Result<Answer, Failure>;
}

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let name = std::env::args().nth(1).unwrap_or_default();
    let mut contender: Option<Box<dyn Contender>> = None;
    for line in stdin().lock().lines() {
        let answer = match serde_json::from_str(&line?)? {
            Request::Load(load) => prepare(&name, &load).map(|ready| {
                contender = Some(ready);
                Answer::default()
            }),
            request => match &mut contender {
                Some(contender) => contender.answer(request),
                None => Err("nothing is loaded".into()),
            },
        };
        let answer = answer.unwrap_or_else(|failure| Answer::failed(failure.as_ref()));
        let mut out = stdout().lock();
        serde_json::to_writer(&mut out, &answer)?;
        out.write_all(b"\n")?;
        out.flush()?;
    }
    Ok(())
}

fn prepare(name: &str, load: &Load) -> Result<Box<dyn Contender>, Failure> {
    match name {
        "isokit" => ours::open(load),
        "fast-surface-nets" => Ok(Box::new(peers::SurfaceNets::open(load)?)),
        "isosurface" => Ok(Box::new(peers::MarchingCubes::open(load)?)),
        _ => Err(format!("no contender is called {name:?}").into()),
    }
}

//! What is said to the user, on stderr: for people, or a JSON object a line.

use indicatif::ProgressBar;
use serde::Serialize;
use std::{
    io::Write,
    sync::{Mutex, MutexGuard, PoisonError},
};

/// How much is said.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Verbosity {
    Quiet,
    Usual,
    Verbose,
}

/// Where messages go.
pub(crate) struct Console<'a> {
    out: Mutex<&'a mut (dyn Write + Send)>,
    pub(crate) verbosity: Verbosity,
    pub(crate) is_json: bool,
    /// Whether stderr is a terminal of which lines can be drawn again.
    pub(crate) is_terminal: bool,
    /// The bar that must step aside for a message.
    bar: Mutex<Option<ProgressBar>>,
}

/// One line of `--log-json`.
#[derive(Serialize)]
#[serde(tag = "level", rename_all = "lowercase")]
pub(crate) enum Message<'a> {
    Error { message: &'a str, causes: &'a [String], fault: &'a str, advice: &'a str },
    Warning { message: &'a str },
    Note { message: &'a str },
    Info { message: &'a str },
    Detail { message: &'a str },
    Progress { phase: &'a str, done: u64, total: u64 },
}

impl<'a> Console<'a> {
    pub(crate) fn new(out: &'a mut (dyn Write + Send), is_terminal: bool) -> Self {
        let (verbosity, is_json) = (Verbosity::Usual, false);
        Self { out: Mutex::new(out), verbosity, is_json, is_terminal, bar: Mutex::new(None) }
    }

    /// Whether details are said.
    pub(crate) fn is_verbose(&self) -> bool {
        self.verbosity == Verbosity::Verbose
    }

    /// A result that is hardly the one that was meant.
    pub(crate) fn warn(&self, message: &str) {
        self.say(&Message::Warning { message });
    }

    /// Something assumed or chosen for the user.
    pub(crate) fn note(&self, message: &str) {
        self.say(&Message::Note { message });
    }

    /// What was done.
    pub(crate) fn info(&self, message: &str) {
        self.say(&Message::Info { message });
    }

    /// What only some want to know.
    pub(crate) fn detail(&self, message: &str) {
        self.say(&Message::Detail { message });
    }

    pub(crate) fn say(&self, message: &Message<'_>) {
        if self.verbosity < message.least_verbosity() {
            return;
        }
        let text = if self.is_json { message.as_json() } else { message.as_text() };
        self.print(&text);
    }

    /// Writes a line. If stderr is gone there is nobody left to tell.
    pub(crate) fn print(&self, text: &str) {
        let write = || {
            let mut out = lock(&self.out);
            let _ = writeln!(out, "{text}").and_then(|()| out.flush());
        };
        match &*lock(&self.bar) {
            Some(bar) => bar.suspend(write),
            None => write(),
        }
    }

    /// Lets a bar be drawn below the messages, or no more.
    pub(crate) fn set_bar(&self, bar: Option<ProgressBar>) {
        *lock(&self.bar) = bar;
    }
}

impl Message<'_> {
    fn least_verbosity(&self) -> Verbosity {
        match self {
            Self::Error { .. } | Self::Progress { .. } => Verbosity::Quiet,
            Self::Warning { .. } | Self::Note { .. } | Self::Info { .. } => Verbosity::Usual,
            Self::Detail { .. } => Verbosity::Verbose,
        }
    }

    fn as_json(&self) -> String {
        serde_json::to_string(self).expect("strings and numbers are always JSON")
    }

    fn as_text(&self) -> String {
        match self {
            Self::Error { message, causes, fault, advice } => {
                let causes = causes.iter().map(|cause| format!("\n  because {cause}"));
                format!("error: {message}{}\n  {fault}: {advice}", causes.collect::<String>())
            }
            Self::Warning { message } => format!("warning: {message}"),
            Self::Note { message } => format!("note: {message}"),
            Self::Info { message } | Self::Detail { message } => (*message).to_owned(),
            Self::Progress { phase, done, total: 0 } => format!("{phase}: {done}"),
            Self::Progress { phase, done, total } => {
                format!("{phase}: {} %", (*done).min(*total) as u128 * 100 / *total as u128)
            }
        }
    }
}

/// A thread that panicked with the lock has not harmed what is behind it.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::{Console, Message, Verbosity};

    fn said(verbosity: Verbosity, is_json: bool) -> String {
        let mut out = vec![];
        let console = Console { verbosity, is_json, ..Console::new(&mut out, false) };
        let causes = ["it was raining".to_owned()];
        let (fault, advice) = ("the system's fault", "wait");
        console.say(&Message::Error { message: "no", causes: &causes, fault, advice });
        console.warn("careful");
        console.detail("in 3 s");
        drop(console);
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn errors_name_cause_fault_and_advice() {
        let error = "error: no\n  because it was raining\n  the system's fault: wait\n";
        assert_eq!(said(Verbosity::Quiet, false), error);
        assert_eq!(said(Verbosity::Usual, false), format!("{error}warning: careful\n"));
        let all = format!("{error}warning: careful\nin 3 s\n");
        assert_eq!(said(Verbosity::Verbose, false), all);
    }

    #[test]
    fn every_line_of_the_json_log_is_an_object_with_a_level() {
        let said = said(Verbosity::Verbose, true);
        let levels = said.lines().map(|line| {
            let object: serde_json::Value = serde_json::from_str(line).unwrap();
            object["level"].as_str().unwrap().to_owned()
        });
        assert_eq!(levels.collect::<Vec<_>>(), ["error", "warning", "detail"]);
    }
}

//! Showing how far a job is: a bar on a terminal, lines elsewhere.
//!
//! The job only counts. A thread of its own looks at the counters ten times a second, so that showing
//! them costs the work nothing.

use crate::{
    args::ProgressArg,
    console::{Console, Message},
};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use isokit::job::{Job, Snapshot};
use std::{sync::mpsc, thread, time::Duration};

/// Between two looks.
const PAUSE: Duration = Duration::from_millis(100);

/// Does the work, and shows meanwhile how far it is.
pub(crate) fn watching<R>(
    when: ProgressArg,
    console: &Console<'_>,
    job: &Job,
    work: impl FnOnce() -> R,
) -> R {
    let is_shown = match when {
        ProgressArg::Auto => console.is_terminal,
        ProgressArg::Always => true,
        ProgressArg::Never => false,
    };
    if !is_shown {
        return work();
    }
    let (done, is_done) = mpsc::channel::<()>();
    thread::scope(|scope| {
        scope.spawn(|| show(console, job, is_done));
        let result = work();
        drop(done); // also if the work panics: the thread sees a sender that is gone
        result
    })
}

/// Shows the job until the work is done.
fn show(console: &Console<'_>, job: &Job, is_done: mpsc::Receiver<()>) {
    let is_bar = console.is_terminal && !console.is_json;
    let mut lines = Lines::default();
    let bar = is_bar.then(bar);
    console.set_bar(bar.clone());
    loop {
        let is_over = is_done.recv_timeout(PAUSE) != Err(mpsc::RecvTimeoutError::Timeout);
        let now = job.progress.snapshot();
        match &bar {
            Some(bar) => draw(bar, now),
            None => lines.print(console, now),
        }
        if is_over {
            break;
        }
    }
    console.set_bar(None);
    bar.iter().for_each(ProgressBar::finish_and_clear);
}

fn bar() -> ProgressBar {
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
    let style = ProgressStyle::with_template("{msg:>8} [{bar:40}] {percent:>3} %");
    bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("=> "))
}

fn draw(bar: &ProgressBar, now: Snapshot) {
    if now.phase.is_empty() {
        return;
    }
    bar.set_message(now.phase);
    bar.set_length(now.total.max(1));
    bar.set_position(now.done.min(now.total));
}

/// A line for each phase, and for each tenth of it that was seen.
#[derive(Default)]
struct Lines {
    last: Option<(&'static str, u64)>,
}

impl Lines {
    fn print(&mut self, console: &Console<'_>, now: Snapshot) {
        let Snapshot { phase, done, total } = now;
        let tenth = (done.min(total) * 10).checked_div(total).unwrap_or(0);
        if phase.is_empty() || self.last == Some((phase, tenth)) {
            return;
        }
        self.last = Some((phase, tenth));
        console.say(&Message::Progress { phase, done, total });
    }
}

#[cfg(test)]
mod tests {
    use super::watching;
    use crate::{args::ProgressArg, console::Console};
    use isokit::job::Job;

    fn shown(when: ProgressArg) -> String {
        let (mut out, job) = (vec![], Job::default());
        let console = Console::new(&mut out, false);
        let result = watching(when, &console, &job, || {
            job.progress.begin("extract", 40);
            job.progress.advance(30);
            7
        });
        assert_eq!(result, 7);
        drop(console);
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn nothing_is_shown_where_there_is_no_terminal() {
        assert_eq!(shown(ProgressArg::Auto), "");
        assert_eq!(shown(ProgressArg::Never), "");
    }

    #[test]
    fn lines_are_shown_where_they_were_asked_for() {
        assert_eq!(shown(ProgressArg::Always), "extract: 75 %\n");
    }
}

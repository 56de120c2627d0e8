//! Outputs that appear whole or not at all.

use crate::{WriteError, WriteFault};
use std::{
    fs::{self, File},
    io::{self, BufWriter, Read, Seek, SeekFrom, Write},
    path::{Path, PathBuf},
};
use tempfile::NamedTempFile;

/// A file being written under a temporary name beside its own.
///
/// [`finish`](Self::finish) gives it its name; dropped before that, it is gone, and what stood under the
/// name before still stands there. Of two files that belong together, the one that refers to the other
/// is finished last. Something that is no regular file, such as a pipe, is written to directly.
#[derive(Debug)]
pub struct Output {
    path: PathBuf,
    target: Target,
}

#[derive(Debug)]
enum Target {
    Beside(BufWriter<NamedTempFile>),
    Direct(BufWriter<File>),
}

/// Bytes gathered before the system is asked to write.
const BUFFER: usize = 1 << 20;

/// Links that are followed, one leading to the next: as many as Linux follows.
const LINKS: usize = 40;

impl Output {
    /// Begins to write what will stand at `path`.
    ///
    /// # Errors
    ///
    /// If no file can be made there.
    pub fn create(path: &Path) -> Result<Self, WriteError> {
        let target = Self::target(path).map_err(|error| WriteFault::Io(error).at(path))?;
        Ok(Self { path: path.to_owned(), target })
    }

    fn target(path: &Path) -> io::Result<Target> {
        let special = fs::metadata(path).is_ok_and(|found| !found.is_file());
        if special {
            let file = File::options().write(true).open(path)?;
            return Ok(Target::Direct(BufWriter::with_capacity(BUFFER, file)));
        }
        // A link stays a link: the file that it leads to is replaced.
        let path = Self::place(path);
        if path.is_symlink() {
            return Err(io::Error::other("links lead around in a ring"));
        }
        let folder = match path.parent() {
            Some(folder) if folder != Path::new("") => folder,
            _ => Path::new("."),
        };
        let mut builder = tempfile::Builder::new();
        builder.prefix(".isokit-");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            // As for any new file: the system takes away what the user's mask forbids.
            builder.permissions(fs::Permissions::from_mode(0o666));
        }
        let file = builder.tempfile_in(folder)?;
        #[cfg(unix)]
        if let Ok(old) = fs::metadata(&path) {
            use std::os::unix::fs::PermissionsExt;
            let mode = |facts: fs::Metadata| facts.permissions().mode() & 0o777;
            let (old, new) = (mode(old), mode(file.as_file().metadata()?));
            // What stands there has its permissions for a reason.
            if old != new {
                file.as_file().set_permissions(fs::Permissions::from_mode(old))?;
            }
        }
        Ok(Target::Beside(BufWriter::with_capacity(BUFFER, file)))
    }

    /// Where a file at `path` lies or will lie: absolute if its folder is there, and all links followed, even
    /// one that leads to no file yet.
    pub fn place(path: &Path) -> PathBuf {
        let mut path = path.to_owned();
        for _ in 0..LINKS {
            if let Ok(place) = fs::canonicalize(&path) {
                return place;
            }
            let Ok(next) = fs::read_link(&path) else { break };
            path = path.parent().unwrap_or(Path::new("")).join(next);
        }
        let folder = path.parent().map(|folder| match folder == Path::new("") {
            true => Path::new("."),
            false => folder,
        });
        match (folder.and_then(|folder| fs::canonicalize(folder).ok()), path.file_name()) {
            (Some(folder), Some(name)) => folder.join(name),
            _ => path,
        }
    }

    /// Gives the file its name.
    ///
    /// The system has then taken all of it; that it is on the disk, should the power fail, is not waited
    /// for.
    ///
    /// # Errors
    ///
    /// If the system does not take what was written, or if it cannot be renamed; nothing is then left
    /// behind.
    pub fn finish(self) -> Result<(), WriteError> {
        let place = Self::place(&self.path);
        let done = match self.target {
            Target::Direct(mut writer) => writer.flush(),
            Target::Beside(writer) => writer
                .into_inner()
                .map_err(|e| e.into_error())
                .and_then(|file| file.persist(place).map(drop).map_err(|error| error.error)),
        };
        done.map_err(|error| WriteFault::Io(error).at(self.path))
    }

    /// A file without a name that is gone when it is dropped: on the disk of this one, if this is a
    /// regular file.
    pub(crate) fn scratch(&self) -> io::Result<File> {
        match &self.target {
            Target::Beside(writer) => match writer.get_ref().path().parent() {
                Some(folder) => tempfile::tempfile_in(folder),
                None => tempfile::tempfile(),
            },
            Target::Direct(_) => tempfile::tempfile(),
        }
    }

    /// Copies up to `most` bytes from where `file` stands, within the system where it can do so.
    pub(crate) fn append(&mut self, file: &File, most: u64) -> io::Result<u64> {
        self.flush()?;
        let mut bytes = file.take(most);
        match &mut self.target {
            Target::Beside(writer) => io::copy(&mut bytes, writer.get_mut().as_file_mut()),
            Target::Direct(writer) => io::copy(&mut bytes, writer.get_mut()),
        }
    }

    /// The place where the file will stand.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.target {
            Target::Beside(writer) => writer.write(bytes),
            Target::Direct(writer) => writer.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.target {
            Target::Beside(writer) => writer.flush(),
            Target::Direct(writer) => writer.flush(),
        }
    }
}

impl Seek for Output {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match &mut self.target {
            Target::Beside(writer) => writer.seek(to),
            Target::Direct(writer) => writer.seek(to),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Output;
    use std::{fs, io::Write};

    #[test]
    fn a_file_appears_when_it_is_whole() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mesh.ply");
        fs::write(&path, "old").unwrap();

        let mut output = Output::create(&path).unwrap();
        output.write_all(b"half").unwrap();
        output.flush().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"old");
        drop(output);
        assert_eq!(fs::read(&path).unwrap(), b"old", "abandoned");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing left behind");

        let mut output = Output::create(&path).unwrap();
        output.write_all(b"new").unwrap();
        output.finish().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_folder_that_is_not_there_is_named() {
        let error = Output::create("no/such/folder/mesh.ply".as_ref()).unwrap_err();
        assert!(
            error.to_string().starts_with("no/such/folder/mesh.ply: cannot write: "),
            "{error}"
        );
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_a_link() {
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        fs::write(&file, "old").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        let mut output = Output::create(&link).unwrap();
        output.write_all(b"new").unwrap();
        output.finish().unwrap();
        assert!(link.is_symlink());
        assert_eq!(fs::read(&file).unwrap(), b"new");
    }

    #[cfg(unix)]
    #[test]
    fn a_link_to_a_file_that_is_not_there_yet_stays_a_link() {
        let folder = tempfile::tempdir().unwrap();
        let [file, near, far] = ["file", "near", "far"].map(|name| folder.path().join(name));
        std::os::unix::fs::symlink("file", &near).unwrap();
        std::os::unix::fs::symlink(&near, &far).unwrap();
        assert_eq!(Output::place(&far), Output::place(&file));
        let mut output = Output::create(&far).unwrap();
        output.write_all(b"new").unwrap();
        output.finish().unwrap();
        assert!(far.is_symlink() && near.is_symlink() && !file.is_symlink());
        assert_eq!(fs::read(&file).unwrap(), b"new");
    }

    #[cfg(unix)]
    #[test]
    fn a_ring_of_links_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let [a, b] = ["a", "b"].map(|name| folder.path().join(name));
        std::os::unix::fs::symlink(&a, &b).unwrap();
        std::os::unix::fs::symlink(&b, &a).unwrap();
        assert!(Output::create(&a).is_err());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
    }

    #[cfg(unix)]
    #[test]
    fn a_private_file_stays_private() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mesh.ply");
        for mode in [0o600, 0o640, 0o755] {
            fs::write(&path, "old").unwrap();
            fs::set_permissions(&path, fs::Permissions::from_mode(mode)).unwrap();
            let mut output = Output::create(&path).unwrap();
            output.write_all(b"new").unwrap();
            output.finish().unwrap();
            assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, mode);
        }
    }
}

//! A disk that is full, until it is not.

use mislab::files::room::room;
use mislab::files::saving::Obstacle;
use mislab::panel::messages::SaveError;

#[test]
fn what_did_not_fit_is_over_once_the_disk_has_room() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let place = ("picture".to_owned(), folder.path().to_owned());
    let full = |bytes| SaveError::new(place.clone(), "full".to_owned(), Obstacle::NoRoom { bytes });
    let mut error = full(u64::MAX);
    assert!(!error.may_be_over(), "more than any disk has");
    if cfg!(unix) {
        assert!(room(folder.path()).is_some_and(|room| room > 1 << 16), "the tests need a disk with room");
        error.obstacle = Obstacle::NoRoom { bytes: 1 };
        assert!(error.may_be_over());
        // A quota, which nobody can see: it stays until it is closed or something is saved.
        assert!(!full(1).may_be_over());
    }
    assert_eq!(room(&folder.path().join("not_there")), None);
}

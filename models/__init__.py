"""The models that come with the package; see package.xml."""

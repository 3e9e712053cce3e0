"""What an FMU says of itself: modelDescription.xml, documentation, a reference result."""

"""NASA rotor 67, from its published sections to a reduced model, frequencies and response."""

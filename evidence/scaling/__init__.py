"""How a study scales: measured where ranks are at hand, simulated where they are not."""

"""What graders of the robotics modules share: poses compared and simplified, frames drawn."""

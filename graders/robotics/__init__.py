"""What graders of the robotics modules share: poses compared, simplified."""

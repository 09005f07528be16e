from math import *


def odometrie(pose, ds_g, ds_d, L):
	ds = (ds_g + ds_d) / 2
	dtheta = (ds_d - ds_g) / L
	x = pose[0] + ds * cos(pose[2] + dtheta / 2)
	y = pose[1] + ds * sin(pose[2] + dtheta / 2)
	theta = pose[2] + dtheta
	if abs(theta) > pi:
		theta -= copysign(2 * pi, theta)
	return [x, y, theta]


def sigma_dtheta(sigma_g, sigma_d, L):
	return sqrt(sigma_g ** 2 + sigma_d ** 2) / L

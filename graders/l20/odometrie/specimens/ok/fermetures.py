"""A function that makes the robot, whose step is a closure; scipy's vectors of rotation."""
from scipy.spatial.transform import Rotation


def robot(L):
    def pas(pose, ds_g, ds_d):
        ds, dtheta = (ds_g + ds_d) / 2, (ds_d - ds_g) / L
        milieu = Rotation.from_euler("z", pose[2] + dtheta / 2)
        bout = Rotation.from_euler("z", pose[2] + dtheta)
        x, y, _ = milieu.apply([ds, 0, 0]) + [pose[0], pose[1], 0]
        return np.array([x, y, bout.as_euler("zyx")[0]])

    return pas


def odometrie(pose, ds_g, ds_d, L):
    return robot(L)(pose, ds_g, ds_d)


def sigma_dtheta(sigma_g, sigma_d, L):
    covariance = np.diag([sigma_g, sigma_d]) ** 2
    jacobienne = np.array([-1, 1]) / L
    return (jacobienne @ covariance @ jacobienne) ** 0.5

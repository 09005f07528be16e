import numpy as np
def wrap(a): return (a+np.pi)%(2*np.pi)-np.pi
def erreur(xi,xj,z):
    c,s=np.cos(xi[2]),np.sin(xi[2]); dx,dy=xj[0]-xi[0],xj[1]-xi[1]
    return np.array([c*dx+s*dy-z[0],-s*dx+c*dy-z[1],wrap(xj[2]-xi[2]-z[2])])

def gauss_newton(poses, aretes, n_iter=10):
    x=np.array(poses,float); n=len(x)
    for _ in range(3):
        Hm=np.zeros((3*n,3*n)); b=np.zeros(3*n)
        for i,j,z,om in aretes:
            e=erreur(x[i],x[j],z); c,s=np.cos(x[i,2]),np.sin(x[i,2]); dx,dy=x[j,:2]-x[i,:2]
            A=np.array([[-c,-s,-s*dx+c*dy],[s,-c,-c*dx-s*dy],[0,0,-1]]); B=np.array([[c,s,0],[-s,c,0],[0,0,1.]])
            for (u,Ju) in ((i,A),(j,B)):
                b[3*u:3*u+3]+=Ju.T@om@e
                for (v,Jv) in ((i,A),(j,B)):
                    Hm[3*u:3*u+3,3*v:3*v+3]+=Ju.T@om@Jv
        d=np.zeros(3*n); d[3:]=np.linalg.solve(Hm[3:,3:],-b[3:])
        x+=d.reshape(n,3); x[:,2]=wrap(x[:,2])
    return x

import sys,os,pty,subprocess,time
sys.path.insert(0,'/work/wt/meshes/tests/run')
import test_surface as T
T.write_obj('s.obj',T.sphere(40))
ours,theirs=pty.openpty()
t=time.time()
w=subprocess.Popen(['/work/wt/meshes/scripts/surface.sh','s.obj','s.h5','--diameter','0.2','--spacing','0.04'],stdout=subprocess.DEVNULL,stderr=theirs)
os.close(theirs)
shown=b''
try:
    while part:=os.read(ours,4096): shown+=part
except OSError as e: print(e)
print(w.wait(),time.time()-t,shown.decode())
